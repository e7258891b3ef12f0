"""A twin that cannot be stepped finely is diagnosed at its own step."""

from __future__ import annotations

from pathlib import Path

from gmfbo import FmuTwin
from gmfbo.sources.export.export import export_augmented
from tests.diagnosis.short_recordings import SERVO, diagnosed, multisine, named


def test_friction_is_found_in_a_twin_that_refuses_finer_steps(tmp_path: Path) -> None:
    recordings = SERVO.recordings({"coulomb_friction.level": 0.2}, (multisine,))
    with SERVO.twin() as twin:
        # Exported at one substep, the FMU answers anything but whole steps with an error.
        fixed = export_augmented(twin, tmp_path, parameters={}, physics=[], settings={}, substeps=1)

    with FmuTwin(fixed.twin_file) as stiff:
        found = diagnosed(stiff, recordings, only=["coulomb_friction", "transport_delay"])
    assert named(found) == ["coulomb_friction"]
    assert any("finer communication step" in note for note in found.notes)
    level = found.effects[0].parameters["level"].value
    assert abs(level - 0.2) < 0.02
