"""Which recordings contradict the reference that was asked for, and which do not."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.reference import sine_reference, step_reference
from gmfbo.tuning.told.contradiction import refuse_other_reference

ASKED = step_reference(0.2, at=0.1, horizon=0.5, unit="m")
TIME = np.arange(0.0, 0.9, 0.0013)  # a slower logger that runs on
BAND = 0.02


def logged(values: np.ndarray) -> Recording:
    return Recording(time=TIME, signals={"reference": values, "position": 0.0 * TIME}, name="r.csv")


def followed(reference: Recording) -> np.ndarray:
    rows = np.searchsorted(reference.time, TIME + 1e-9, side="right") - 1
    return reference.signals["reference"][rows]


def test_the_reference_asked_for_is_taken_from_any_logger() -> None:
    counts = np.round(followed(ASKED) / 2e-4) * 2e-4
    refuse_other_reference(ASKED, logged(counts), BAND)
    late = Recording(time=TIME, signals={"reference": np.append(0.0, counts[:-1])})
    refuse_other_reference(ASKED, late, BAND)
    refuse_other_reference(ASKED, Recording(time=TIME, signals={"position": TIME}), BAND)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (1e3 * followed(ASKED), "1000 times smaller"),
        (-followed(ASKED), r"-1 times as much"),
        (followed(ASKED) + 0.05, "goes from 0.05 to 0.25"),
        (0.0 * TIME, "goes from 0 to 0, but 0 to 0.2 m"),
        (followed(step_reference(0.2, at=0.4, horizon=0.5)), "asked for"),
    ],
)
def test_another_reference_is_refused(values: np.ndarray, words: str) -> None:
    with pytest.raises(RecordingError, match=words):
        refuse_other_reference(ASKED, logged(values), BAND)


def test_another_frequency_contradicts_a_sine() -> None:
    asked = sine_reference(1.0, 2.0, 2.0)
    refuse_other_reference(asked, logged(followed(asked)), BAND)
    with pytest.raises(RecordingError, match="record again"):
        refuse_other_reference(asked, logged(followed(sine_reference(1.0, 3.0, 3.0))), BAND)
