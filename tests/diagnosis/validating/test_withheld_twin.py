"""A twin that meets unseen recordings worse than it came is not handed back, and that is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo import diagnose
from gmfbo.cli.diagnosis.diagnosis_screen import screenful
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE
from tests.diagnosis.example_diagnoses import FIT, friction
from tests.diagnosis.short_recordings import SERVO, moves, multisine, triangle

SAID = "the twin as it came meets the unseen recordings better"
FRICTION = {"coulomb_friction.level": 0.25, "coulomb_friction.deflection": 1e-6}
WITHHELD = replace(friction(), fit=replace(FIT, twin_is_withheld=True))


def diagnosed(physics: dict[str, float]) -> Diagnosis:
    """Fitted to an axis with friction, and scored on one with other physics."""
    fitted = SERVO.recordings(FRICTION, (multisine, moves))
    unseen = SERVO.recordings(physics, (triangle,))
    excluded = [name for name in CATALOGUE if name != "coulomb_friction"]
    return diagnose(SERVO.twin(), fitted, unseen, exclude=excluded, jobs=1)


def test_a_twin_of_another_axis_is_withheld(tmp_path: Path) -> None:
    found = diagnosed({})
    assert found.fit.twin_is_withheld
    assert found.augmentation is None
    assert SAID in found.sentence
    with pytest.raises(InputError, match=SAID):
        found.augmented_twin()
    found.save(tmp_path)
    assert not (tmp_path / "augmented.fmu").exists()
    assert Diagnosis.from_json(tmp_path).fit.twin_is_withheld


def test_a_twin_of_the_same_axis_is_handed_back() -> None:
    """Negative control."""
    found = diagnosed(FRICTION)
    assert not found.fit.twin_is_withheld
    assert found.augmentation is not None
    assert SAID not in found.sentence


def test_it_is_said_in_terminal_prompt_and_report() -> None:
    page = diagnosis_page(WITHHELD)
    assert SAID in " ".join(" ".join(screenful(WITHHELD)).split())
    assert SAID in repr(WITHHELD)
    assert SAID in page
    assert SAID not in diagnosis_page(friction())
