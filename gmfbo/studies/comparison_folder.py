"""Folder of a comparison: a line for each run, and the tables derived from the runs."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gmfbo.errors import StoreError
from gmfbo.files.durable import cause, write_whole
from gmfbo.recordings.store.memory_store import StudyRecord
from gmfbo.recordings.store.pack import pack_record
from gmfbo.recordings.store.writer_lock import WriterLock
from gmfbo.reports.comparison.curves import Landscape
from gmfbo.studies.comparison_table import Table
from gmfbo.studies.curves import curves_of, curves_text
from gmfbo.studies.landscape import landscape_text
from gmfbo.studies.outcome import Outcome, read_outcomes, write_outcomes
from gmfbo.tuning.methods import METHODS


@dataclass(frozen=True)
class ComparisonFolder:
    """A folder `NAME.compare`.

    A line of `runs/METHOD.jsonl` is the outcome of a finished run. `trials/METHOD-SEED.h5` holds
    all its trials where they are kept, and `truth/` the plant over the box. `table.txt`,
    `curves.txt` and `landscape.txt` follow from these, and the figures from the three tables.

    Attributes
    ----------
    path : Path
        The folder.
    """

    path: Path

    @property
    def table(self) -> Path:
        """File of the tables for reading."""
        return self.path / "table.txt"

    @property
    def curves(self) -> Path:
        """Means over seeds, run by run."""
        return self.path / "curves.txt"

    @property
    def landscape(self) -> Path:
        """The plant over two gains."""
        return self.path / "landscape.txt"

    @property
    def truth(self) -> Path:
        """Grids of the plant and of the twin."""
        return self.path / "truth"

    def keep(self, outcome: Outcome, record: StudyRecord | None) -> None:
        """Keep a finished run, its trials first.

        Parameters
        ----------
        outcome : Outcome
            Outcome of the run.
        record : StudyRecord or None
            All trials, if they are kept.
        """
        if record is not None:
            (self.path / "trials").mkdir(exist_ok=True)
            label = f"{outcome.method}-{outcome.seed}"
            pack_record(record, self.path / "trials" / f"{label}.h5")
        (self.path / "runs").mkdir(exist_ok=True)
        path = self.path / "runs" / f"{outcome.method}.jsonl"
        kept = read_outcomes(path) if path.exists() else []
        write_outcomes(path, [*kept, outcome])

    def keep_truth(self, grids: Mapping[str, bytes]) -> None:
        """Keep grids of the plant, given by file name."""
        self.truth.mkdir(exist_ok=True)
        for name, content in grids.items():
            write_whole(self.truth / name, content)

    @property
    def finished_runs(self) -> list[Outcome]:
        """Outcome of each finished run.

        Raises
        ------
        StoreError
            One of them is damaged.
        """
        paths = sorted((self.path / "runs").glob("*.jsonl"))
        return [outcome for path in paths for outcome in read_outcomes(path)]

    @contextlib.contextmanager
    def writing(self) -> Iterator[None]:
        """Lock the folder against other processes; it is made if missing.

        Raises
        ------
        StoreError
            It cannot be written, or another process writes it.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            lock = WriterLock(self.path / ".lock")
        except OSError as error:
            raise StoreError(f"{self.path}: cannot write there: {cause(error)}") from None
        try:
            yield
        finally:
            lock.release()

    def outcomes(self, key: str) -> list[Outcome]:
        """All finished runs.

        Parameters
        ----------
        key : str
            Hash of the content that all runs share.

        Raises
        ------
        StoreError
            They are of another study, or one of them is damaged.
        """
        kept = self.finished_runs
        if any(outcome.study != key for outcome in kept):
            raise StoreError(
                f"{self.path}: holds runs of another study file, twin or grid, which must not be "
                "mixed; give another --out, or remove it"
            )
        return kept

    def log_command(self, command: str) -> list[str]:
        """Add a command to the log of commands; returns all, each once.

        Parameters
        ----------
        command : str
            Command of the user, without options that do not change the result.
        """
        file = self.path / "commands.json"
        known: list[str] = json.loads(file.read_text(encoding="utf-8")) if file.exists() else []
        if command not in known:
            known.append(command)
            write_whole(file, (json.dumps(known, indent=1) + "\n").encode())
        return known

    def write_tables(
        self, outcomes: Sequence[Outcome], heading: Sequence[str], landscape: Landscape | None
    ) -> str:
        """Write all tables, and return the one for reading.

        Parameters
        ----------
        outcomes : sequence of Outcome
            At least one.
        heading : sequence of str
            Lines above the tables.
        landscape : Landscape or None
            None leaves it out.
        """
        columns = by_method(outcomes)
        text = "\n".join([*heading, ""]) + "\n" + Table(columns).text()
        write_whole(self.table, text.encode())
        write_whole(self.curves, curves_text(curves_of(columns)).encode())
        if landscape is not None:
            write_whole(self.landscape, landscape_text(landscape).encode())
        return text


def by_method(outcomes: Sequence[Outcome]) -> Mapping[str, list[Outcome]]:
    """Group outcomes by method: in the order of `gmfbo methods`, then a user's own by name."""
    known = list(METHODS)
    names = sorted(
        {outcome.method for outcome in outcomes},
        key=lambda name: (known.index(name) if name in known else len(known), name),
    )
    ordered = sorted(outcomes, key=lambda outcome: outcome.seed)
    return {name: [one for one in ordered if one.method == name] for name in names}
