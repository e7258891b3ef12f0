"""Means over seeds with intervals, run by run, for the figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from gmfbo.errors import StoreError
from gmfbo.reports.comparison.curves import Curve
from gmfbo.studies.bootstrap import Interval
from gmfbo.studies.outcome import Outcome

HEAD = ("method", "curve", "number", "mean", "low", "high", "seeds")

_CURVES: tuple[tuple[str, int, Callable[[Outcome], Sequence[float]]], ...] = (
    ("objective", 1, lambda one: one.best),
    ("regret", 1, lambda one: one.regret),
    ("cost", 0, lambda one: one.cost),
)
"""Name, number of its first entry, and the entries: by real runs, and for the cost by queries."""


def curves_of(by_method: Mapping[str, Sequence[Outcome]]) -> list[Curve]:
    """Average over seeds, up to the shortest seed of a method.

    Parameters
    ----------
    by_method : mapping of str to sequence of Outcome
        In the order in which they are drawn.
    """
    made = []
    for method, outcomes in by_method.items():
        for name, first, entries in _CURVES:
            each = [entries(one) for one in outcomes]
            shortest = min(map(len, each))
            table = np.array([row[:shortest] for row in each])
            spans = [Interval.of(column, np.mean) for column in table.T]
            made.append(
                Curve(
                    method=method,
                    name=name,
                    x=np.arange(first, first + shortest, dtype=float),
                    mean=np.array([span.value for span in spans]),
                    low=np.array([span.low for span in spans]),
                    high=np.array([span.high for span in spans]),
                    seeds=len(each),
                )
            )
    return made


def curves_text(curves: Sequence[Curve]) -> str:
    """Write curves as a table, a line a point.

    Parameters
    ----------
    curves : sequence of Curve
        Result of `curves_of`.
    """
    lines = [" ".join(HEAD)]
    for curve in curves:
        for x, mean, low, high in zip(curve.x, curve.mean, curve.low, curve.high, strict=True):
            lines.append(
                f"{curve.method} {curve.name} {x:.0f} {mean:.6g} {low:.6g} {high:.6g} {curve.seeds}"
            )
    return "\n".join(lines) + "\n"


def read_curves(path: Path) -> list[Curve]:
    """Read a table written by `curves_text`.

    Parameters
    ----------
    path : Path
        A text file.

    Raises
    ------
    StoreError
        It is missing, or no table of curves.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
        if tuple(lines[0].split()) != HEAD:
            raise ValueError
        points: dict[tuple[str, str], list[list[float]]] = {}
        for line in lines[1:]:
            method, name, *numbers = line.split()
            points.setdefault((method, name), []).append([float(number) for number in numbers])
    except (OSError, ValueError, IndexError):
        raise StoreError(
            f"{path}: expected the curves of a comparison; make them with "
            "'gmfbo compare STUDY.toml --out FOLDER'"
        ) from None
    made = []
    for (method, name), rows in points.items():
        x, mean, low, high, seeds = np.array(rows).T
        made.append(Curve(method, name, x, mean, low, high, int(seeds[0])))
    return made
