"""Tables of the plants beside the main one: cheap rivals, misleading twins, runs that leave."""

from __future__ import annotations

import numpy as np

from tests.benchmarks.plants import safety, twin_kinds
from tests.benchmarks.plants.arrival import read_lines
from tests.benchmarks.plants.catalogue import PLANTS
from tests.benchmarks.tables.plants import OURS, arrivals
from tests.benchmarks.tables.tuning import table

CHEAP = ("textbook_rule", "twin_once")


def cheap_rivals() -> str:
    """Ours beside the textbook's rule and the twin's optimum, at 5 % of the way."""
    found, methods = arrivals(), (OURS, *CHEAP)
    rows = []
    for plant in PLANTS:
        cells = []
        for method in methods:
            runs = found.runs[plant, method]
            never = sum(n is None for n in runs.values())
            cells.append(f"{found.mean(plant, method):.1f} ({never})")
        rows.append([f"`{plant}`", *cells])
    means = [f"{found.geometric_mean(list(PLANTS), method):.1f}" for method in methods]
    rows.append(["geometric mean", *means])
    return table(["plant", *(f"`{method}`" for method in methods)], rows)


def misled() -> str:
    """Runs to target with misleading and with perfect twins; of `bo_ei` in brackets."""
    rows = []
    for kind in twin_kinds.KINDS:
        found = twin_kinds.runs_of(kind)
        cells = [
            f"{own.mean():.1f} ({peer.mean():.1f})" if peer.size else f"{own.mean():.1f}"
            for own, peer in (found[name] for name in twin_kinds.CHOSEN)
        ]
        losses = [float((own - peer).mean()) for own, peer in found.values() if peer.size]
        runs = np.concatenate([own for own, _ in found.values()])
        told = f"{np.mean(losses):+.1f}" if losses else f"median {np.median(runs):g}"
        rows.append([kind.replace("_", " "), *cells, told])
    heads = ["twin", *(f"`{name}`" for name in twin_kinds.CHOSEN), "mean loss"]
    return table(heads, rows)


def leaving() -> str:
    """Runs after the initial ones that left the envelope."""
    lines = read_lines(safety.FOLDER)
    rows = []
    for method in safety.METHODS:
        cells = [safety.left(lines, method, [name]) for name in safety.LIMITED]
        gone, count = safety.left(lines, method, safety.LIMITED)
        told = [f"{one} of {of}" for one, of in cells]
        rows.append([f"`{method}`", *told, f"{100.0 * gone / count:.1f} %"])
    heads = ["method", *(f"`{name}`" for name in safety.LIMITED), "all"]
    return table(heads, rows)
