"""Which fixed parameters compete, and about which values."""

from __future__ import annotations

from gmfbo import FmuTwin, models_folder
from gmfbo.diagnosis.comparison.opened_comparison import _fixed_parameters


def test_values_given_to_a_twin_stand_for_those_of_its_fmu() -> None:
    """A friction that was set to zero was freed about that of the FMU, which it had hidden."""
    given = {"friction.coulomb": 0.0, "friction.stribeck": 0.5}
    with FmuTwin(models_folder() / "drive_twin.toml", parameters=given) as twin:
        freed = {one.name: one for one in _fixed_parameters(twin, ())}
    assert "friction.coulomb" not in freed
    assert freed["friction.stribeck"].nominal == 0.5
    assert freed["friction.presliding"].nominal == 1e-3
