"""The table of `against_the_true_law`: errors, sets and widths beside those of the true law."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import binom

from tests.blind.draw.errors_of_the_true_law import joint_ratio, told_errors
from tests.blind.draw.judging import judge
from tests.blind.draw.measures import clopper_pearson
from tests.blind.draw.separated_sets import separated, smallest
from tests.blind.gains import OWED
from tests.blind.machines import MACHINES

Line = Mapping[str, Any]

_BARS = {"error": 1.25, "sets": 5.0, "width": 1.5}
"""What was asked: ratio of errors, share of sets [%], ratio of widths."""


def table(lines: Sequence[Line], outcomes: Sequence[Line]) -> str:
    """Text of all that was compared with the true law.

    Parameters
    ----------
    lines : sequence of mapping
        Of `against_the_true_law`.
    outcomes : sequence of mapping
        Of the runner, for the cases that have no line.
    """
    judged = [judge(one) for one in outcomes]
    owed = [one for one in judged if one.stratum == "owed" and one.is_owed]
    known = {line["case"] for line in lines}
    missing = sum(one.case not in known for one in owed)
    parts = [
        f"{len(lines)} cases compared; {missing} of {len(owed)} owed ones not yet",
        _errors([line for line in lines if line["held_out"]], outcomes),
        _sets(lines),
        _widths(lines),
    ]
    return "\n\n".join(parts) + "\n"


def quantile_told(values: Sequence[float], share: float) -> str:
    """A quantile with its exact interval of 95 %, such as `1.20 [1.10, 1.31]`.

    The interval is between two of the values in their order, chosen by the binomial law of how many
    lie below the quantile (Conover 1999, "Practical Nonparametric Statistics", section 3.2).

    Parameters
    ----------
    values : sequence of float
        Independent ones.
    share : float
        Of them below the quantile.
    """
    if not values:
        return "-"
    low, high = quantile_interval(values, share)
    return f"{np.quantile(values, share):.4g} [{low:.4g}, {high:.4g}]"


def quantile_interval(values: Sequence[float], share: float) -> tuple[float, float]:
    """Ends of the interval of `quantile_told`; infinite where there are too few values.

    Parameters
    ----------
    values : sequence of float
        Independent ones.
    share : float
        Of them below the quantile.
    """
    order, n = np.sort(values), len(values)
    below = int(binom.ppf(0.025, n, share))  # fewer lie below the quantile in 2.5 % at most
    above = int(binom.ppf(0.975, n, share)) + 1
    low = order[below - 1] if below >= 1 else -np.inf
    high = order[above - 1] if above <= n else np.inf
    return float(low), float(high)


def _errors(lines: Sequence[Line], outcomes: Sequence[Line]) -> str:
    """Ratios of held-out errors of owed cases."""
    shown = [line for line in lines if "ratio" in line["held_out"]]
    named = [line for line in shown if line["held_out"]["named"]]
    why = Counter(line["held_out"]["why"] for line in lines if "why" in line["held_out"])
    rows = [
        "Owed: held-out error of what was told over that of the true law fitted to the same "
        f"recordings (asked: median at most {_BARS['error']})",
        f"{'':<34}{'cases':>6}   median; 90 %; at most {_BARS['error']}",
    ]
    for title, own in (
        ("all, the twin where nothing is told", shown),
        ("something is told", named),
        ("right", [line for line in shown if line["outcome"] == "right"]),
        ("an honest set", [line for line in shown if line["outcome"] == "set"]),
        ("closed loops", [line for line in shown if not line["machine"].startswith("bench")]),
        ("open loops, whole runs", [one for one in shown if one["machine"].startswith("bench")]),
    ):
        ratios = [line["held_out"]["ratio"] for line in own]
        close = sum(ratio <= _BARS["error"] for ratio in ratios)
        told = f"{quantile_told(ratios, 0.5)}; {quantile_told(ratios, 0.9)}; {_share(close, own)}"
        rows.append(f"{title:<36}{len(own):>4}   {told}")
    diagnoses = {one["case"]: one["diagnosis"] for one in outcomes}
    alone = [_of_the_twin(line, diagnoses[line["case"]]) for line in shown]
    close = sum(ratio <= _BARS["error"] for ratio in alone)
    told = f"{quantile_told(alone, 0.5)}; {quantile_told(alone, 0.9)}; {_share(close, alone)}"
    rows.append(f"{'for comparison, the refitted twin':<36}{len(alone):>4}   {told}")
    rows.append(f"no ratio: {sum(why.values())}" + "".join(f"; {n} {w}" for w, n in why.items()))
    far = sorted(shown, key=lambda line: -line["held_out"]["ratio"])
    rows += ["largest"] + [
        f"{line['held_out']['ratio']:8.3g}  {line['case']} {line['machine']} "
        f"{' + '.join(line['hidden'])}: {line['outcome']}"
        for line in far
        if line["held_out"]["ratio"] > _BARS["error"]
    ]
    return "\n".join(rows)


def _of_the_twin(line: Line, diagnosis: Mapping[str, Any]) -> float:
    """The same ratio of the refitted twin, without what was told."""
    signals = diagnosis["fit"]["signals"]
    nameless = {
        name: {**errors, "augmented": None} | {"free_run": _nameless(errors["free_run"])}
        for name, errors in signals.items()
    }
    is_open = MACHINES[line["machine"]].is_open_loop
    twin = told_errors({"fit": {"signals": nameless}}, is_open)
    held = line["held_out"]
    return joint_ratio(twin, held["true"], held["noise"])


def _nameless(free_run: Mapping[str, Any] | None) -> dict[str, Any] | None:
    return None if free_run is None else {**free_run, "augmented": None}


def _sets(lines: Sequence[Line]) -> str:
    """Statements that hold a hidden law, by whether an oracle tells it from the others."""
    own = [(line, one) for line in lines for one in line["statements"]]
    counts = Counter(_kind(one) for _, one in own)
    apart, sets = counts["separated", True] + counts["separated", False], counts["separated", True]
    all_apart = apart + counts["no rival", False]
    rows = [
        "Owed and pairs: statements that hold a hidden law by its name; separated is one whose law "
        f"gains more than {OWED:g} over each rival (asked: at most {_BARS['sets']:g} % of the "
        "separated told as sets)",
        f"{'':<34}{'told as a set':>14}{'told alone':>12}",
    ]
    rows += [
        f"{kind:<34}{counts[kind, True]:>14}{counts[kind, False]:>12}"
        for kind in ("separated", "not separated", "no rival")
    ]
    rows += [
        f"{'sets among the separated':<34}{_share(sets, range(apart))}",
        f"{'the same, no rival counted there':<34}{_share(sets, range(all_apart))}",
        "sets, and rivals that an oracle cannot tell from a law that was told alone",
    ]
    for line, one in own:
        if one["told"] or _kind(one)[0] == "not separated":
            gains = ", ".join(
                f"{rival} {'no end' if gain is None else format(gain, '.3g')}"
                for rival, gain in one["gains"].items()
            )
            how = "set" if one["told"] else "alone"
            rows.append(
                f"  {line['case']} {line['machine']} {one['law']}, {how}: gain over {gains}"
            )
    return "\n".join(rows)


def _kind(statement: Mapping[str, Any]) -> tuple[str, bool]:
    """Whether the law is told apart by an oracle, and whether it was told in a set."""
    if smallest(statement["gains"]) is None:
        return "no rival", bool(statement["told"])
    return "separated" if separated(statement) else "not separated", bool(statement["told"])


def _widths(lines: Sequence[Line]) -> str:
    """Widths of intervals over the narrowest ones, by kind, as median and quartiles."""
    own = [(line, one) for line in lines for one in line["intervals"]]
    groups = {
        "twin's parameters": [one for _, one in own if one["kind"] == "parameter"],
        "laws' values": [one for _, one in own if one["kind"] == "law"],
        "both": [one for _, one in own],
        "  that hold the truth": [one for _, one in own if one["holds"]],
        "  that do not": [one for _, one in own if not one["holds"]],
        "  closed loops": [one for line, one in own if not _is_open(line)],
        "  open loops": [one for line, one in own if _is_open(line)],
        "parameters, nulls": [
            one for line, one in own if one["kind"] == "parameter" and line["stratum"] == "null"
        ],
    }
    rows = [
        "Intervals of 95 %: width over the narrowest by Cramer and Rao "
        f"(asked: median at most {_BARS['width']}; median [its interval]; quartiles; values)"
    ]
    for key, what in _BOUNDS.items():
        rows.append(what)
        for title, told in groups.items():
            ratios = _ratios(told, key)
            close = sum(ratio <= _BARS["width"] for ratio in ratios)
            rows.append(
                f"  {title:<26}{quantile_told(ratios, 0.5):<26}{_quartiles(ratios):<18}"
                f"{len(ratios):>4} of {len(told)}; at most {_BARS['width']}: {close}"
            )
    return "\n".join([*rows, *_by_law([one for _, one in own if one["kind"] == "law"])])


_BOUNDS = {
    "narrowest": "offset, scale and shift of the logged columns are unknown too",
    "narrowest_without": "the columns are known to be right",
    "by_frequency": "columns unknown, frequencies of a closed loop's recording as if independent",
}
"""What counts as unknown in each bound."""


def _by_law(intervals: Sequence[Mapping[str, Any]]) -> list[str]:
    laws: dict[str, list[Mapping[str, Any]]] = {}
    for one in intervals:
        laws.setdefault(one["name"].split(".")[0], []).append(one)
    rows = [f"{'laws, columns unknown':<32}{'median':>8}{'by frequency':>14}  values; that hold"]
    for law, told in sorted(laws.items()):
        cells = [_median(_ratios(told, key)) for key in ("narrowest", "by_frequency")]
        held = sum(one["holds"] for one in told)
        rows.append(f"  {law:<30}{cells[0]:>8}{cells[1]:>14}  {len(told)}; {held}")
    return rows


def _is_open(line: Line) -> bool:
    return bool(MACHINES[line["machine"]].is_open_loop) if line["machine"] in MACHINES else False


def _median(values: Sequence[float]) -> str:
    return f"{np.median(values):.3g}" if values else "-"


def _quartiles(values: Sequence[float]) -> str:
    if not values:
        return "-"
    low, high = np.quantile(values, [0.25, 0.75])
    return f"{low:.3g} to {high:.3g}"


def _ratios(intervals: Sequence[Mapping[str, Any]], key: str) -> list[float]:
    return [one["width"] / one[key] for one in intervals if one[key]]


def _share(count: int, total: Sequence[object]) -> str:
    """`3 of 40: 7.5 % [1.6, 20.4]`, the interval by Clopper and Pearson."""
    if not len(total):
        return "0 of 0"
    low, high = (100.0 * bound for bound in clopper_pearson(count, len(total)))
    return f"{count} of {len(total)}: {100.0 * count / len(total):.1f} % [{low:.1f}, {high:.1f}]"
