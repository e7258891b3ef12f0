"""Outcome of one method on one seed, kept as a line of text."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Self

from gmfbo.errors import StoreError
from gmfbo.files.durable import write_whole


@dataclass(frozen=True)
class Outcome:
    """One finished study of a comparison.

    Attributes
    ----------
    study : str
        Hash of the content that compared studies share: study file, twins, grid.
    method : str
        Its name.
    seed : int
        Of the study.
    n_star : int or None
        Real runs, initial ones included, until the best is within 2 % of the way from the optimum
        to the median; None where the method never arrived.
    n_star_paper : int or None
        n* within 20 queries of both sources after the initial data.
    most_real_runs : int
        Real runs that the budget allows; a method that never arrived counts as one more.
    least, median : float
        True optimum and median cost over the box, of the plant at the end.
    best, regret : tuple of float
        After each real run: least true cost g; simple regret, 1 at the median cost.
    cost : tuple of float
        After the initial data and each query: cost of all runs so far in units of a real run.
    seconds : tuple of float
        [s] Wall clock of each query, with all runs that it caused.
    seconds_before : float
        [s] Wall clock of the initial data.
    twin_runs, corrected_runs : int
        Number of runs of IS2 and IS3, with initial runs and surveys.
    version : str
        Of gmfbo.
    alarms : tuple of int or None
        Real runs at which a change of the plant was detected; None in a run of an early version.
    """

    study: str
    method: str
    seed: int
    n_star: int | None
    n_star_paper: int | None
    most_real_runs: int
    least: float
    median: float
    best: tuple[float, ...]
    regret: tuple[float, ...]
    cost: tuple[float, ...]
    seconds: tuple[float, ...]
    seconds_before: float
    twin_runs: int
    corrected_runs: int
    version: str
    alarms: tuple[int, ...] | None = None

    @property
    def queries(self) -> int:
        """Number of queries of both sources after the initial data."""
        return len(self.seconds)

    @property
    def never(self) -> int:
        """Substitute for n* where the method never arrived."""
        return self.most_real_runs + 1

    @property
    def line(self) -> str:
        """The outcome as a line of text, without its end."""
        return json.dumps(asdict(self))

    @classmethod
    def of_line(cls, line: str) -> Self:
        """Read a line made by `line`.

        Parameters
        ----------
        line : str
            With or without its end.

        Raises
        ------
        ValueError
            The text is no outcome.
        """
        try:
            raw = json.loads(line)
            values = {
                field.name: raw[field.name] for field in fields(cls) if field.name != "alarms"
            }
            values["alarms"] = raw.get("alarms")
        except (KeyError, TypeError, AttributeError):
            raise ValueError("a field is lacking") from None
        lists = {name: tuple(v) for name, v in values.items() if isinstance(v, list)}
        return cls(**{**values, **lists})


def read_outcomes(path: Path) -> list[Outcome]:
    """Read the finished runs of one method.

    Parameters
    ----------
    path : Path
        File written by `write_outcomes`.

    Raises
    ------
    StoreError
        It cannot be read, or a line is no finished run.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        raise StoreError(f"{path}: cannot be read; remove it to have its runs made again") from None
    outcomes = []
    for number, line in enumerate(lines, start=1):
        try:
            outcomes.append(Outcome.of_line(line))
        except ValueError:
            raise StoreError(
                f"{path}: expected the text of a finished run in line {number}; remove the line "
                "to have the run made again"
            ) from None
    return outcomes


def write_outcomes(path: Path, outcomes: Iterable[Outcome]) -> None:
    """Write the finished runs of one method, a line each by seed; a whole file or none.

    Parameters
    ----------
    path : Path
        A `.jsonl`.
    outcomes : iterable of Outcome
        Of one method.
    """
    ordered = sorted(outcomes, key=lambda outcome: outcome.seed)
    write_whole(path, "".join(f"{one.line}\n" for one in ordered).encode())
