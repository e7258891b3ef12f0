"""A first study loads as it is, and asks for no more than an axis has done."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.tuning.study_file.first_study import FirstStudy, first_study_text, round_step
from gmfbo.tuning.study_file.study_file import parse_study


@given(st.floats(1e-9, 1e9))
def test_a_step_has_one_digit_and_hardly_exceeds_what_was_recorded(height: float) -> None:
    step = round_step(height)
    assert 0.5 * height < step <= 1.01 * height
    assert float(f"{step:.0e}") == step


def test_the_peak_between_two_samples_costs_no_digit() -> None:
    assert round_step(0.39999) == 0.4
    assert round_step(0.389) == 0.3
    assert round_step(0.0) == 0.0


@pytest.mark.parametrize("unit", ["rad", ""])
def test_its_text_says_what_it_was_told(unit: str) -> None:
    first = FirstStudy('a "b"', "twin.toml", "enc_phi", 0.4, unit, 5e-4, 2.0, "a guess")
    study = parse_study(first_study_text(first), label="study.toml", default_name="x")
    assert (study.name, study.is2.twin, study.is1.ask_tell) == ('a "b"', "twin.toml", True)
    assert (study.reference.step, study.reference.horizon) == (0.4, 2.0)
    assert (study.reference.at, study.reference.sample_time) == (0.05, 5e-4)
    assert study.objective.signal == "enc_phi"
    rehearsal = first_study_text(first).replace("ask_tell = true", "#").replace("# twin", "twin", 1)
    assert parse_study(rehearsal, label="s", default_name="x").is1.twin == "twin.toml"
