"""What a bench is told of the next run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from gmfbo.recordings.recording import Recording
from gmfbo.tuning.query.request import TrialRequest
from gmfbo.tuning.told.next_run import NEXT, write_next_run


def test_a_script_is_told_the_note_too(tmp_path: Path) -> None:
    request = TrialRequest(7, "IS1", {"k": 0.1 + 0.2}, note="you may stop here")
    reference = Recording(np.arange(3.0), {"reference": np.array([0.0, 1.0, 1.0])})
    write_next_run(tmp_path, request, [reference])
    told = json.loads((tmp_path / NEXT).read_text(encoding="utf-8"))
    assert told["note"] == "you may stop here"
    assert told["gains"] == {"k": 0.1 + 0.2}
