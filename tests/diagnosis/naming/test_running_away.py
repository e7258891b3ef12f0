"""An effect with which the twin runs away is told as one that could not be tested."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from gmfbo import FmuTwin
from tests.diagnosis.short_recordings import Axis, decided, multisine, open_small
from tests.diagnosis.wired_bench import BENCH

TWIN = (
    BENCH.replace('command = "controller.u"', 'command = "STATE"')
    .replace('sensor = "controller.measured"', 'command = "plant.current"')
    .replace("[ports]", '[uncertain]\n"plant.viscous" = [0.0, 0.08]\n[ports]')
)


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
