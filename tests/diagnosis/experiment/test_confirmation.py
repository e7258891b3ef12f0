"""What a confirmation run says follows from how far each prediction was off."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.experiment.observed import FAR, Confirmation, Prediction, save_confirmation
from gmfbo.errors import InputError

RESIDUALS = 2000


def prediction(name: str, per_residual: float, fitted: float = 1.0) -> Prediction:
    return Prediction(name, per_residual * RESIDUALS, per_residual, fitted, {"position": 0.01})


def observed(*predictions: Prediction, threshold: float = 30.0) -> Confirmation:
    nearest = tuple(sorted(predictions, key=lambda p: p.chi2))
    return Confirmation("next.csv", (1.0, 3.0), nearest, threshold)


LAG, DELAY = prediction("actuator_lag", 1.1), prediction("transport_delay", 1.4)
PLAIN = prediction("parameters", 40.0, 20.0)


def test_the_nearest_is_supported_where_the_next_is_farther_than_the_threshold() -> None:
    told = observed(DELAY, LAG, PLAIN)
    assert told.outcome == "supports"
    assert told.best.name == "actuator_lag"
    assert told.behind(DELAY) == pytest.approx(0.3 * RESIDUALS / 1.1)
    assert told.strength == "strongly"
    assert "strongly supports actuator lag: it leaves 1 times the noise, " in told.sentence
    assert told.sentence.endswith("transport delay 1.2 times.")


@pytest.mark.parametrize(
    ("threshold", "strength"), [(300.0, "narrowly"), (100.0, "clearly"), (30.0, "strongly")]
)
def test_strength_counts_thresholds(threshold: float, strength: str) -> None:
    assert observed(DELAY, LAG, threshold=threshold).strength == strength


def test_two_that_both_fit_are_not_told_apart() -> None:
    told = observed(LAG, replace(DELAY, chi2=LAG.chi2 + 10.0, per_residual=1.105), PLAIN)
    assert told.outcome == "cannot_tell"
    assert [p.name for p in told.alike] == ["actuator_lag", "transport_delay"]
    assert (
        "cannot tell actuator lag and transport delay apart: all leave about 1 times"
        in told.sentence
    )


def test_none_is_supported_where_the_nearest_is_twice_as_far_off_as_at_the_diagnosis() -> None:
    told = observed(prediction("actuator_lag", 20.0), prediction("transport_delay", 30.0), PLAIN)
    assert told.outcome == "none"
    assert "supports none of them: the nearest, actuator lag, leaves 4.5 times" in told.sentence


def test_an_explanation_that_removes_most_is_supported_in_kind() -> None:
    told = observed(prediction("actuator_lag", 6.0), prediction("parameters", 400.0, 300.0))
    assert told.outcome == "supports_in_kind"
    assert told.removed == pytest.approx(394.0 / 399.0)
    assert "in kind, not yet in size" in told.sentence


def test_the_twin_alone_is_not_supported_for_having_been_bad_before() -> None:
    """Its own misfit was 20: that is no licence to be off by 40."""
    assert observed(PLAIN, prediction("actuator_lag", 90.0)).outcome == "none"


def test_the_only_explanation_is_confirmed_or_not() -> None:
    assert (
        "is as the refitted twin alone predicted"
        in observed(prediction("parameters", 1.2)).sentence
    )
    assert observed(prediction("parameters", 12.0)).outcome == "none"


def test_a_diagnosis_that_left_more_allows_more() -> None:
    left = observed(prediction("coulomb_friction", 20.0, 8.0), prediction("parameters", 90.0, 70.0))
    assert left.expected == 8.0
    assert left.outcome == "supports"


misfits = st.floats(0.1, 1e4)


@given(st.lists(misfits, min_size=1, max_size=4), misfits, st.floats(1.0, 500.0))
def test_the_outcome_is_consistent_with_its_numbers(
    left: list[float], fitted: float, threshold: float
) -> None:
    made = [prediction(f"effect_{k}", m, fitted) for k, m in enumerate(left)]
    told = observed(*made, threshold=threshold)
    assert told.best.per_residual == min(left)
    assert told.alike[0] is told.best
    assert all(told.behind(p) > threshold for p in told.predictions if p not in told.alike)
    if told.outcome in ("supports", "cannot_tell"):
        assert min(left) <= FAR * max(1.0, fitted)
    assert (told.outcome == "cannot_tell") == (told.fits(told.best) and len(told.alike) > 1)
    assert told.sentence.endswith(".")


def test_confirmations_are_kept_by_recording(tmp_path: Path) -> None:
    first = observed(LAG, DELAY, PLAIN)
    path = save_confirmation(first, tmp_path)
    save_confirmation(replace(first, recording="other.csv"), tmp_path)
    save_confirmation(replace(first, threshold=9e9), tmp_path)
    content = json.loads(path.read_text())
    assert content["schema"] == 1
    assert [run["recording"] for run in content["runs"]] == ["other.csv", "next.csv"]
    again = content["runs"][1]
    assert again["outcome"] == "cannot_tell"
    assert [p["name"] for p in again["predictions"]] == [p.name for p in first.predictions]
    assert again["predictions"][1]["behind"] == pytest.approx(first.behind(first.predictions[1]))


def test_where_nothing_was_left_to_remove_null_is_written(tmp_path: Path) -> None:
    told = observed(LAG, DELAY)
    assert math.isnan(told.removed)
    content = json.loads(save_confirmation(told, tmp_path).read_text())
    assert content["runs"][0]["removed"] is None


def test_a_file_of_others_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "confirmation.json").write_text("[]")
    with pytest.raises(InputError, match="move the file away"):
        save_confirmation(observed(LAG), tmp_path)
    assert (tmp_path / "confirmation.json").read_text() == "[]"
