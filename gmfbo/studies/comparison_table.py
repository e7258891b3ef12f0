"""Tables of a comparison as text: every seed, and statistics over all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.studies.bootstrap import Interval
from gmfbo.studies.one_run import PAPER_QUERIES
from gmfbo.studies.outcome import Outcome

BASELINES = ("bo_ei", "gmfbo")
"""Methods with which the others are compared seed by seed."""

SEEDS_A_LINE = 25

Column = dict[int, float]
"""A number by seed."""


@dataclass(frozen=True)
class Table:
    """Outcomes by method and seed.

    Attributes
    ----------
    by_method : mapping of str to list of Outcome
        In the order of the columns, each by rising seed.
    """

    by_method: Mapping[str, Sequence[Outcome]]

    @property
    def seeds(self) -> list[int]:
        """All seeds, rising."""
        return sorted({one.seed for column in self.by_method.values() for one in column})

    def text(self) -> str:
        """All tables, a row a method; only the last depends on the machine."""
        never = next(iter(self.by_method.values()))[0].never
        parts = [
            f"n*: real runs to the optimum, initial ones counted (never: {never})",
            *self._arrivals(_n_star),
            "",
            f"the same within {PAPER_QUERIES} queries of either source after the initial data",
            *self._arrivals(_n_star_paper),
            "",
            *self._differences(),
            "means over seeds, at the end",
            *self._means(),
            "",
            *self._alarms(),
            "n* of each seed",
            *self._each_seed(),
            "",
            "time [s]",
            *self._times(),
        ]
        return "\n".join(parts) + "\n"

    def _arrivals(self, field: Callable[[Outcome], int | None]) -> list[str]:
        heads = ["median", "95 %", "mean", "95 %", "90 % within", "never", "seeds"]
        lines = [self._row("", heads)]
        for name, outcomes in self.by_method.items():
            sample = np.array(list(_column(outcomes, field).values()))
            missed = 100.0 * np.mean([field(one) is None for one in outcomes])
            cells = [
                f"{np.median(sample):.1f}",
                _span(sample, np.median),
                f"{np.mean(sample):.2f}",
                _span(sample, np.mean),
                _late(sample),
                f"{missed:.0f} %",
                str(len(sample)),
            ]
            lines.append(self._row(name, cells))
        return lines

    def _differences(self) -> list[str]:
        columns = {name: _column(outcomes, _n_star) for name, outcomes in self.by_method.items()}
        lines: list[str] = []
        for baseline in [name for name in BASELINES if name in columns]:
            others = [name for name in columns if name != baseline]
            if not others:
                continue
            lines += [
                f"n* less that of {baseline} on the same seed (below zero: fewer real runs)",
                self._row("", ["mean", "95 %", "fewer", "as many", "more", "seeds"]),
            ]
            for name in others:
                shared = sorted(columns[name].keys() & columns[baseline].keys())
                if not shared:
                    lines.append(self._row(name, ["no seed in common"]))
                    continue
                less = np.array([columns[name][s] - columns[baseline][s] for s in shared])
                counts = [int(np.sum(less < 0)), int(np.sum(less == 0)), int(np.sum(less > 0))]
                cells = [f"{less.mean():.2f}", _span(less, np.mean), *map(str, counts)]
                lines.append(self._row(name, [*cells, str(len(shared))]))
            lines.append("")
        return lines

    def _means(self) -> list[str]:
        fields: tuple[tuple[str, Callable[[Outcome], float], str], ...] = (
            ("queries", lambda one: one.queries, ".1f"),
            ("real runs", lambda one: len(one.regret), ".1f"),
            ("twin runs", lambda one: one.twin_runs, ".1f"),
            ("corrected", lambda one: one.corrected_runs, ".1f"),
            ("cost", lambda one: one.cost[-1], ".1f"),
            ("regret", lambda one: one.regret[-1], ".4f"),
        )
        return self._by_field([(label, field, np.mean, form) for label, field, form in fields])

    def _alarms(self) -> list[str]:
        """Detected changes of the plant; false alarms where the plant does not change."""
        lines = [
            "changes of the plant that were noticed",
            self._row("", ["studies", "of", "first at", "changes"]),
        ]
        for name, outcomes in self.by_method.items():
            noticed = [one.alarms for one in outcomes if one.alarms is not None]
            first = [alarms[0] for alarms in noticed if alarms]
            cells = [
                str(len(first)),
                str(len(noticed)),
                f"{np.median(first):.1f}" if first else "-",
                str(sum(map(len, noticed))),
            ]
            if noticed:
                lines.append(self._row(name, cells))
        return [*lines, ""] if len(lines) > 2 else []

    def _each_seed(self) -> list[str]:
        """Blocks of rows, each with as many seeds as fit a screen's width."""
        columns = {name: _column(outcomes, _n_star) for name, outcomes in self.by_method.items()}
        lines = []
        for first in range(0, len(self.seeds), SEEDS_A_LINE):
            seeds = self.seeds[first : first + SEEDS_A_LINE]
            wide = 1 + max(2, *(len(str(seed)) for seed in seeds))
            for label, cells in [
                ("seed", [str(seed) for seed in seeds]),
                *(
                    (name, [_whole(column.get(s)) for s in seeds])
                    for name, column in columns.items()
                ),
            ]:
                lines.append(self._labelled(label, cells, wide))
        return lines

    def _times(self) -> list[str]:
        def iteration(one: Outcome) -> float:
            return float(np.median(one.seconds)) if one.seconds else np.nan

        return self._by_field(
            [
                ("a query", iteration, np.median, ".2f"),
                ("before", lambda one: one.seconds_before, np.median, ".1f"),
                ("in all", _all_seconds, np.mean, ".0f"),
            ]
        )

    def _by_field(
        self,
        fields: Sequence[
            tuple[str, Callable[[Outcome], float], Callable[[list[float]], object], str]
        ],
    ) -> list[str]:
        lines = [self._row("", [label for label, *_ in fields])]
        for name, outcomes in self.by_method.items():
            cells = [
                format(statistic([field(one) for one in outcomes]), form)
                for _, field, statistic, form in fields
            ]
            lines.append(self._row(name, cells))
        return lines

    def _row(self, label: str, cells: Sequence[str]) -> str:
        return self._labelled(label, cells, 16)

    def _labelled(self, label: str, cells: Sequence[str], wide: int) -> str:
        longest = max(len(name) for name in self.by_method)
        return (f"{label:<{longest}}" + "".join(f"{cell:>{wide}}" for cell in cells)).rstrip()


def _n_star(one: Outcome) -> int | None:
    return one.n_star


def _n_star_paper(one: Outcome) -> int | None:
    return one.n_star_paper


def _all_seconds(one: Outcome) -> float:
    return one.seconds_before + sum(one.seconds)


def _column(outcomes: Sequence[Outcome], field: Callable[[Outcome], int | None]) -> Column:
    arrived = {one.seed: field(one) for one in outcomes}
    never = {one.seed: one.never for one in outcomes}
    return {seed: float(never[seed] if n is None else n) for seed, n in arrived.items()}


def _whole(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"


def _span(sample: NDArray[np.float64], statistic: Callable[..., NDArray[np.float64]]) -> str:
    interval = Interval.of(sample, statistic)
    return f"[{interval.low:.1f}, {interval.high:.1f}]"


def _late(sample: NDArray[np.float64]) -> str:
    """Real runs within which nine of ten seeds arrived, by an order statistic."""
    return f"{np.quantile(sample, 0.9, method='higher'):.0f}"
