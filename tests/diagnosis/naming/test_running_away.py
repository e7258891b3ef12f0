"""An effect with which the twin runs away is told as one that could not be tested."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from gmfbo import FmuTwin, models_folder
from tests.diagnosis.short_recordings import Axis, decided, multisine, open_small

TWIN = f"""
name = "motor under a PD controller"
step = 1e-3
[fmus]
controller = {{ kind = "pd_filtered", kp = 10.0, kd = 0.3 }}
plant = "{(models_folder() / "motor_bench.fmu").as_posix()}"
[wires]
"plant.current" = "controller.u"
"controller.measured" = "plant.position"
[inputs]
reference = "controller.reference"
[outputs]
position = "plant.position"
current = "controller.u"
[uncertain]
"plant.viscous" = [0.0, 0.08]
[ports]
torque = "plant.tau_load"
command = "plant.current"
[states]
position = "plant.position"
velocity = "plant.velocity"
command = "STATE"
[roles]
inertia = "plant.inertia"
"""


def reasons(folder: Path, state: str) -> dict[str, str]:
    path = folder / "twin.toml"
    path.write_text(TWIN.replace("STATE", state), encoding="utf-8")
    twin = FmuTwin(path)
    made = Axis(truth={}, gains={}, noise={"position": 4e-5}).recordings(
        {}, [multisine], seconds=1.0, twin=twin
    )
    with closing((case := open_small(twin, made)).simulations):
        return dict(decided(case, ["transport_delay", "coulomb_friction"]).untestable)


def test_a_delay_of_a_command_that_holds_what_it_adds_is_not_testable(tmp_path: Path) -> None:
    """Where the current behind the port is stated as the command, each step answers the last."""
    said = reasons(tmp_path, "plant.motor_current")
    assert said == {"transport_delay": "the twin does not run to its end with it"}


def test_control_the_controllers_command_is_delayed(tmp_path: Path) -> None:
    assert "transport_delay" not in reasons(tmp_path, "controller.u")
