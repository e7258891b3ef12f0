"""Engines that find nothing, fail or take too long, for the tests of the runner."""

from __future__ import annotations

import json
import time
from pathlib import Path


class Said:
    """A diagnosis that tells the files it was given."""

    def __init__(self, recordings: list[Path]) -> None:
        self.recordings = recordings

    def to_json(self) -> str:
        """Content of diagnosis.json."""
        where = sorted(str(path) for path in self.recordings[0].parent.parent.iterdir())
        return json.dumps({"verdict": "none", "effects": [], "location": {"seen": where}})


def silent(twin: Path, recordings: list[Path], jobs: int) -> Said:
    """An engine that finds nothing."""
    assert twin.name == "twin.toml"
    return Said(recordings)


def breaks(twin: Path, recordings: list[Path], jobs: int) -> Said:
    """An engine that fails."""
    raise RuntimeError("no such twin")


def sleeps(twin: Path, recordings: list[Path], jobs: int) -> Said:
    """An engine that takes a minute."""
    time.sleep(60.0)
    return Said(recordings)
