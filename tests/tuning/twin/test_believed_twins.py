"""What is asked where the believed twins leave the safety envelope."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from gmfbo.recordings.recording import Recording
from gmfbo.sources.plants.failed_run import failed_run
from gmfbo.sources.plants.source import Source
from gmfbo.tuning.query.request import TrialRequest
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study

START = {"ctl.Kp": 60.0, "ctl.Kd": 6.0}
SAFETY = """initial_is1 = 1
is1_runs = 9
[safety]
position = [-0.1, {most}]
start = [[60.0, 6.0]]
"""
NEVER_INSIDE, DAMPED_INSIDE = 0.5, 1.1
"""Limits of the position [rad] beside a step to 1: none meets the first, damped runs the second."""


@dataclass
class DoubtfulAxis(AnalyticAxis):
    """A twin that knows its inertia within a factor of four."""

    def believed(self, rng: np.random.Generator) -> Source:
        return AnalyticAxis(inertia=self.inertia * 2.0 ** rng.uniform(-1.0, 1.0))


def study_of(folder: Path, most: float, seed: int = 0) -> Study:
    return write_study(folder, seed=seed, budget=SAFETY.format(most=most))


def tuner_of(study: Study, twin: AnalyticAxis | None = None) -> Tuner:
    return Tuner(study, is1=AnalyticAxis(), is2=twin or AnalyticAxis(inertia=0.2))


def asked(tuner: Tuner, held: Mapping[str, float] | None = None) -> TrialRequest:
    request = tuner.ask(held)
    assert request is not None
    return request


def tell_inside(tuner: Tuner, request: TrialRequest) -> None:
    """Tell a run that stayed at rest, and so inside."""
    reference = tuner.experiment.reference
    tuner.tell(request, Recording(reference.time, {"position": np.zeros(len(reference))}))


def tell_failed(tuner: Tuner, request: TrialRequest) -> None:
    tuner.tell(request, failed_run(tuner.experiment.reference, "door was open"))


def withheld(tuner: Tuner) -> list[Mapping[str, float]]:
    return [e["gains"] for e in tuner.history.store.events() if e["event"] == "withheld"]


def test_the_first_run_is_the_start_wherever_the_twin_leaves_the_envelope(tmp_path: Path) -> None:
    with tuner_of(study_of(tmp_path, NEVER_INSIDE)) as tuner:
        assert asked(tuner).gains == pytest.approx(START)
        assert len(tuner.history.keep_out().unsafe) == 10  # control: each run of the twin left


def test_gains_that_are_asked_are_never_called_withheld(tmp_path: Path) -> None:
    with tuner_of(study_of(tmp_path, NEVER_INSIDE)) as tuner:
        tell_failed(tuner, asked(tuner))
        request = asked(tuner)
        assert request.gains != pytest.approx(START)
        assert request.note == (
            "20 of 20 believed twins leave the envelope at these gains, "
            "and no fewer nearer to the start"
        )
        assert withheld(tuner) == []


def test_a_start_that_left_the_envelope_is_not_known_to_be_safe(tmp_path: Path) -> None:
    with tuner_of(study_of(tmp_path, NEVER_INSIDE)) as tuner:
        first = asked(tuner)
        tuner.tell(first, AnalyticAxis().run(first.gains, tuner.experiment.reference))
        assert tuner.history.of("IS1")[0].status == "unsafe"
        assert asked(tuner).note.endswith("and no gains are known to be safe")


def test_where_nothing_is_safer_a_run_that_stayed_inside_is_repeated_once(tmp_path: Path) -> None:
    with tuner_of(study_of(tmp_path, NEVER_INSIDE)) as tuner:
        tell_inside(tuner, asked(tuner))
        again = asked(tuner)
        assert again.gains == pytest.approx(START)
        assert "nothing on the way to trial 11 is safer, so its gains are repeated" in again.note
        assert withheld(tuner)[-1] != pytest.approx(START)
        tell_inside(tuner, again)
        step = asked(tuner)
        assert step.gains != pytest.approx(START)
        assert step.gains == pytest.approx(START, rel=0.05)
        assert "20 of 20 leave it at these too, a small step from trial 11" in step.note


def test_the_fewest_exits_are_taken_where_no_real_run_stayed_inside(tmp_path: Path) -> None:
    with tuner_of(study_of(tmp_path, 1.0, seed=2), DoubtfulAxis(inertia=0.2)) as tuner:
        tell_failed(tuner, asked(tuner))
        request = asked(tuner)
        assert request.note == (
            "the gains first proposed were withheld: 20 of 20 believed twins left the envelope "
            "there; 11 of 20 leave it at these, the fewest found, and no real run has stayed "
            "inside yet"
        )
        (proposed,) = withheld(tuner)
        assert request.gains != pytest.approx(proposed)


@pytest.mark.parametrize("kp", [100.0, 190.0])
def test_gains_that_are_all_held_are_asked_with_a_note(tmp_path: Path, kp: float) -> None:
    held = {"ctl.Kp": kp, "ctl.Kd": 3.0}
    with tuner_of(study_of(tmp_path, DAMPED_INSIDE)) as tuner:
        tell_inside(tuner, asked(tuner))
        request = asked(tuner, held)
        assert request.gains == held
        assert "20 of 20 believed twins leave the envelope at these gains" in request.note
        assert ("exceed the step limit" in request.note) == (kp > 120.0)
        assert withheld(tuner) == []


def test_a_held_gain_stays_held_where_a_proposal_is_withheld(tmp_path: Path) -> None:
    with tuner_of(study_of(tmp_path, DAMPED_INSIDE)) as tuner:
        tell_inside(tuner, asked(tuner))
        request = asked(tuner, {"ctl.Kd": 4.0})
        assert request.gains["ctl.Kd"] == 4.0
        far = asked(tuner, {"ctl.Kp": 190.0})
        assert far.gains["ctl.Kp"] == 190.0
        assert "the held gains exceed the step limit" in far.note


def test_gains_of_a_run_that_stayed_inside_are_repeated_without_a_word(tmp_path: Path) -> None:
    with tuner_of(study_of(tmp_path, NEVER_INSIDE)) as tuner:
        tell_inside(tuner, asked(tuner))
        assert asked(tuner, START).note == ""
