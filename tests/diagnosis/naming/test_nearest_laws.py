"""Laws that come nearest to what no law holds make the corrected twin better, and are no claim."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gmfbo import diagnose
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.naming.decision import Compared
from gmfbo.diagnosis.naming.row_to_hold import nearest_row
from gmfbo.diagnosis.result.explained import Remainder
from gmfbo.physics import CATALOGUE
from tests.diagnosis.comparison.test_unknown_laws import Array, Torque, recordings, torque_noise
from tests.diagnosis.example_diagnoses import outside
from tests.diagnosis.noise.planted_noise import opened

ASKED = ("coulomb_friction", "elastic_return")


def root_friction(position: Array, velocity: Array, rng: np.random.Generator) -> Array:
    """[N m] In proportion to the root of the speed."""
    return -0.03 * np.sign(velocity) * np.sqrt(np.abs(velocity))


def nearest(torque: Torque, *ports: str) -> list[list[str] | None]:
    """Laws that come nearest to something at each of some ports."""
    with opened(recordings(torque)) as case:
        stated = comparison_of(case, ASKED)
        ledger, scored = stated.run()
        compared = Compared(stated.search, ledger, scored)
        rows = [nearest_row(compared, ledger.rows[frozenset()], port) for port in ports]
        return [None if row is None else sorted(row.elements) for row in rows]


def test_coulomb_friction_comes_nearest_only_where_that_acts() -> None:
    assert nearest(root_friction, "torque", "sensor") == [["coulomb_friction"], None]


def test_nothing_comes_near_to_noise() -> None:
    assert nearest(torque_noise, "torque") == [None]


def test_the_corrected_twin_has_them_and_the_diagnosis_names_nothing() -> None:
    planted = recordings(root_friction)
    left_out = [name for name in CATALOGUE if name not in ASKED]
    found = diagnose(planted.twin, planted.recordings, exclude=left_out, seed=0, jobs=1)
    assert found.verdict == "outside_library"
    assert found.effects == ()
    assert found.remainder is not None
    assert found.remainder.stand_ins == ("coulomb_friction",)
    assert found.augmentation is not None
    physics = {one.name for one in found.augmentation.physics}
    assert physics == {"coulomb_friction.level"}
    command = found.fit.signals["torque_command"]
    assert command.augmented < 0.9 * command.parameters_only
    assert "Coulomb friction comes nearest and stands in for it" in found.sentence
    assert found.detectable == {}  # what is unknown could hide any torque


def standing(*laws: str) -> Diagnosis:
    left = Remainder(0.2, "torque", "velocity", "throughout", stand_ins=laws)
    return replace(outside(), remainder=left)


def test_stand_ins_are_told_as_no_claim() -> None:
    one = standing("coulomb_friction").sentence
    assert "Coulomb friction comes nearest and stands in for it in the corrected twin" in one
    two = standing("coulomb_friction", "gravity_torque").sentence
    assert "Coulomb friction and gravity torque come nearest and stand in for it" in two
    assert "nearest" not in outside().sentence
