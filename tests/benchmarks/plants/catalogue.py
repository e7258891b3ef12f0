"""The plants by name: where their files lie, and what they are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from gmfbo.recordings.recording import Recording
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study_file.safety_section import SafetySection
from tests.benchmarks.plants.truths import blind_plants, cart, mujoco_plants, rotary, thermal
from tests.benchmarks.plants.truths.conditions import Conditions

HERE = Path(__file__).parent

Truth = Callable[[Mapping[str, float], Recording, Conditions], dict[str, Any]]
"""From gains, reference and conditions to columns by name, with `time`."""


@dataclass(frozen=True)
class Plant:
    """A plant, its study and its twin.

    Attributes
    ----------
    name : str
        Folder with `study.toml` and `twin.toml`, and `truth.toml` where the truth is FMUs.
    truth : callable or None
        Plays the plant; None where `truth.toml` does.
    friction : str
        Parameter of `truth.toml` that is the factor of the friction.
    inertia : str
        Parameter of `truth.toml` that is the inertia.
    rule : str
        What of `rules.py` gives the gains of the textbook; empty where no rule fits.
    package : str
        Package that plays it, beside gmfbo's own; empty for none.
    twin : str
        File of its folder, in place of the study's; empty for none.
    safety : mapping of str to (float, float)
        Envelope of its study, by signal; the published studies have none.
    noise : float
        Factor of its measurement noise, and of how much its friction differs from run to run.
    """

    name: str
    truth: Truth | None = None
    friction: str = ""
    inertia: str = ""
    rule: str = ""
    package: str = ""
    twin: str = ""
    safety: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    noise: float = 1.0

    def check(self) -> None:
        """Raise if the package that plays it is missing; else each run would count as failed.

        Raises
        ------
        RuntimeError
            It is not installed.
        """
        if self.package and find_spec(self.package) is None:
            raise RuntimeError(
                f"{self.name}: the package {self.package} is missing: pip install 'gmfbo[tests]'"
            )

    @property
    def folder(self) -> Path:
        """Its files."""
        return HERE / self.name

    def study(self) -> Study:
        """Its study file, read."""
        study = Study.read(self.folder / "study.toml")
        changes: dict[str, Any] = {}
        if self.twin:
            changes["is2"] = study.file.is2.model_copy(update={"twin": self.twin})
        if self.safety:
            changes["safety"] = SafetySection(ranges=dict(self.safety))
        if self.noise != 1.0:
            scaled = {name: self.noise * std for name, std in study.file.is1.noise.items()}
            changes["is1"] = study.file.is1.model_copy(update={"noise": scaled})
        return replace(study, file=study.file.model_copy(update=changes))


PLANTS = {
    plant.name: plant
    for plant in (
        Plant("drive_twin", friction="friction.scale", inertia="load.inertia", rule="pd"),
        Plant("servo_axis", blind_plants.servo_axis, rule="pd"),
        Plant("linear_axis", blind_plants.linear_axis, rule="cascade_p_p"),
        Plant(
            "split_drive",
            friction="plant.friction.scale",
            inertia="plant.load.inertia",
            rule="cascade_p_pi",
        ),
        Plant("two_mass", rotary.two_mass, rule="cascade_p_p"),
        Plant("velocity_loop", rotary.velocity_loop, rule="pi"),
        Plant("temperature", thermal.temperature, rule="pi"),
        Plant("pendulum", cart.pendulum),
        Plant("six_gains", rotary.six_gains, rule="cascade_p_pi"),
        Plant("mujoco_arm", mujoco_plants.mujoco_arm, rule="pid", package="mujoco"),
        Plant("mujoco_belt", mujoco_plants.mujoco_belt, rule="pd", package="mujoco"),
    )
}
"""All plants, in the order of the tables."""
