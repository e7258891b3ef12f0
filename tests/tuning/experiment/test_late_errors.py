"""Late errors of references of any kind: rest where they end constant, growth elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.recordings.recording import Recording
from gmfbo.recordings.reference import sine_reference, step_reference, steps_reference
from gmfbo.tuning.experiment.experiment import ReferenceExperiment
from gmfbo.tuning.experiment.late_errors import late_error_of_run
from gmfbo.tuning.experiment.scoring_terms import ScoringTerms

NOISE = 0.01


def sine(growth: float) -> float:
    """Late error of a run whose error is a tenth of the sine, and grows."""
    part = ReferenceExperiment.from_recording(sine_reference(1.0, 2.0, 4.0), "position")
    time = part.reference.time
    wave = part.reference.signals["reference"]
    error = 0.1 * wave * np.exp(growth * time)
    return late_error_of_run(part, Recording(time, {"position": wave + error}))


def test_the_error_along_a_sine_must_not_grow() -> None:
    assert sine(0.0) <= 1.0
    assert sine(-1.0) <= 1.0
    assert sine(2.0) > 1.0


@pytest.mark.parametrize("seed", range(20))
def test_noise_alone_is_no_growth(seed: int) -> None:
    part = ReferenceExperiment.from_recording(sine_reference(1.0, 2.0, 4.0), "position")
    time = part.reference.time
    noise = NOISE * np.random.default_rng(seed).standard_normal(time.size)
    run = Recording(time, {"position": part.reference.signals["reference"] + noise})
    assert late_error_of_run(part, run) <= 1.0


def test_of_several_steps_the_last_must_come_to_rest() -> None:
    made = steps_reference((0.1, 0.6), (1.0, 0.5), horizon=0.5)
    part = ReferenceExperiment.from_recording(made, "position", horizon=0.5, several=True)
    time, wave = made.time, made.signals["reference"]
    swinging = np.where(time < 0.6, 0.2 * np.sin(60.0 * time) * (time > 0.1), 0.0)
    assert late_error_of_run(part, Recording(time, {"position": wave + swinging})) <= 1.0
    late = np.where(time > 0.6, 0.2 * np.sin(60.0 * time), 0.0)
    assert late_error_of_run(part, Recording(time, {"position": wave + late})) > 1.0


def test_band_and_filter_of_the_objective_count() -> None:
    reference = step_reference(1.0)
    time, wave = reference.time, reference.signals["reference"]
    off = Recording(time, {"position": 1.05 * wave})
    ripple = Recording(time, {"position": wave * (1.0 + 0.1 * np.sin(300.0 * time))})

    def late(run: Recording, terms: ScoringTerms) -> float:
        part = ReferenceExperiment.from_recording(reference, "position", horizon=1.0, terms=terms)
        return late_error_of_run(part, run)

    assert late(off, ScoringTerms()) == pytest.approx(2.5)
    assert late(off, ScoringTerms(band=0.1)) == pytest.approx(0.5)
    assert late(ripple, ScoringTerms()) > 1.0
    assert late(ripple, ScoringTerms(filter_s=0.03)) <= 1.0
