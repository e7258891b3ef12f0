"""What is recommended right after a run, before the twin has run beside it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo import Study, Tuner
from gmfbo.tuning.methods.gmfbo import CORRECTION, Gmfbo
from gmfbo.tuning.query.progress import Progress
from tests.studies.small_study import write_small_study


def test_a_run_is_not_recommended_because_it_was_the_last(tmp_path: Path) -> None:
    study = Study.read(write_small_study(tmp_path))
    quick = Gmfbo(correction=replace(CORRECTION, survey=60))
    told: list[tuple[float, float]] = []
    with Tuner(study, method=quick) as tuner:

        def look(step: Progress) -> None:
            if step.source != "IS1" or step.phase != "query":
                return
            real = tuner.history.of("IS1")
            found = tuner.result().recommendation
            assert found is not None
            (same,) = [one for one in real if one.gains == pytest.approx(found.gains)]
            told.append((same.objective, min(one.objective for one in real)))

        tuner.run(look)
    # Without noise each run is believed as it was observed, and the best one is recommended.
    assert len(told) == 3
    for recommended, least in told:
        assert recommended == pytest.approx(least, abs=1e-3)
