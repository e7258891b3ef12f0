"""The study's gains laid over those of the twin file."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.errors import InputError, StudyFileError
from gmfbo.space import Gain, GainSpace
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.study_file.study_sections import GainRange

TWIN = GainSpace((Gain("ctl.Kp", 30.0, 200.0), Gain("ctl.Kd", 2.0, 10.0)))


def test_without_a_word_in_the_study_the_twins_box_is_tuned() -> None:
    assert GainChoice.combine(TWIN, {}).space == TWIN


def test_the_study_narrows_one_gain_and_leaves_the_other() -> None:
    choice = GainChoice.combine(TWIN, {"ctl.Kd": GainRange(low=3.0, high=4.0, scale="log")})
    assert choice.space.names == ("ctl.Kp", "ctl.Kd")
    assert choice.space.gains[1] == Gain("ctl.Kd", 3.0, 4.0, "log")


def test_a_number_fixes_a_gain_but_it_stays_in_force() -> None:
    choice = GainChoice.combine(TWIN, {"ctl.Kd": GainRange(low=3.0, high=3.0)})
    assert choice.space.names == ("ctl.Kp",)
    values = choice.values(np.array([50.0]))
    assert values == {"ctl.Kp": 50.0, "ctl.Kd": 3.0}
    assert choice.point(values) == np.array([50.0])


def test_a_study_may_tune_a_parameter_that_the_twin_file_does_not_name() -> None:
    choice = GainChoice.combine(TWIN, {"ctl.Ki": GainRange(low=0.0, high=1.0)}, ["ctl.Ki"])
    assert choice.space.names == ("ctl.Kp", "ctl.Kd", "ctl.Ki")


def test_an_unknown_gain_is_refused_with_the_nearest() -> None:
    with pytest.raises(
        StudyFileError, match=r"no FMU parameter 'ctl\.kp'; did you mean 'ctl\.Kp'\?"
    ):
        GainChoice.combine(TWIN, {"ctl.kp": GainRange(low=1.0, high=2.0)})


def test_nothing_to_tune_is_refused() -> None:
    with pytest.raises(StudyFileError, match="nothing to tune"):
        GainChoice.combine(None, {"ctl.Kp": GainRange(low=3.0, high=3.0)})


def test_held_gains_must_be_known_and_in_range() -> None:
    choice = GainChoice.combine(TWIN, {})
    choice.check_fixed({"ctl.Kd": 3.0})
    with pytest.raises(InputError, match=r"no tuned gain 'ctl\.KD'; did you mean 'ctl\.Kd'"):
        choice.check_fixed({"ctl.KD": 3.0})
    with pytest.raises(InputError, match=r"'ctl\.Kd' within \[2, 10\], got 11"):
        choice.check_fixed({"ctl.Kd": 11.0})
