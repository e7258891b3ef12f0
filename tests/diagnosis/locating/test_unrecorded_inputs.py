"""A controller is not judged where one of its inputs was not recorded."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, check
from gmfbo.diagnosis.checking.text import check_lines
from gmfbo.diagnosis.locating.parities import Parities, logged_as, parities
from gmfbo.diagnosis.locating.unrecorded_inputs import unrecorded_inputs
from gmfbo.recordings.recording import Recording
from tests.diagnosis.servo_recordings import opened_with, rewritten
from tests.diagnosis.short_recordings import Axis, multisine
from tests.diagnosis.wired_bench import BENCH

FEEDFORWARD = '[inputs]\nfeedforward = "controller.feedforward"'
STATED = '[parameters]\n"controller.feedforward" = 0.0\n[inputs]'


def bench(folder: Path, inputs: str = "[inputs]") -> FmuTwin:
    """A motor under a controller that has an input for a feedforward."""
    path = folder / "bench.toml"
    path.write_text(BENCH.replace("[inputs]", inputs))
    return FmuTwin(path)


@contextmanager
def opened_parities(twin: FmuTwin, recordings: list[Recording]) -> Iterator[Parities]:
    case = opened_with(twin, recordings)
    try:
        yield parities(case, case.base)
    finally:
        case.simulations.close()


def recorded_by(twin: FmuTwin) -> list[Recording]:
    axis = Axis(truth={}, gains={}, noise={})
    return axis.recordings({}, [multisine], seconds=1.0, twin=twin)


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> list[Recording]:
    return recorded_by(bench(tmp_path_factory.mktemp("driven")))


@pytest.fixture(scope="module")
def fed_forward(tmp_path_factory: pytest.TempPathFactory) -> list[Recording]:
    """Of a drive whose feedforward is not zero."""
    folder = tmp_path_factory.mktemp("fed")
    return recorded_by(bench(folder, STATED.replace("0.0", "0.2")))


def test_controller_that_computes_what_was_recorded_needs_no_unrecorded_input(
    tmp_path: Path, driven: list[Recording]
) -> None:
    """Nothing is wired to the feedforward, and the command comes out without one."""
    with opened_parities(bench(tmp_path), driven) as found:
        assert found.controller is not None
        assert not found.controller.fails
        assert "controller" not in found.why_not


def test_controller_with_an_unrecorded_feedforward_is_not_judged(
    tmp_path: Path, fed_forward: list[Recording]
) -> None:
    with opened_parities(bench(tmp_path), fed_forward) as found:
        assert found.controller is None
        said = found.why_not["controller"]
        assert said.startswith(
            "the controller also reads controller.feedforward, and it was not recorded;"
        )
        # The plant is held by force whatever its command is.
        assert found.plant is not None


@pytest.mark.parametrize("logged", ["held", "new"])
@pytest.mark.parametrize("feedforward", [0.0, 0.2])
def test_which_command_was_logged_shows_beside_an_unrecorded_feedforward(
    tmp_path: Path, logged: str, feedforward: float
) -> None:
    """Beside friction that the twin lacks too: no plant is in the cut loop."""
    stated = STATED.replace("0.0", str(feedforward))
    (made,) = Axis(truth={}, gains={}, noise={"position": 4e-5}).recordings(
        {"coulomb_friction.level": 0.3},
        [multisine],
        seconds=1.0,
        logged_new=["current"] if logged == "new" else [],
        written_by="",
        twin=bench(tmp_path, stated),
    )
    with opened_parities(bench(tmp_path), [made]) as found:
        if feedforward:
            assert found.controller is None
        assert logged_as(found) == logged


def test_input_that_the_twin_file_states_voids_nothing(
    tmp_path: Path, driven: list[Recording]
) -> None:
    with opened_parities(bench(tmp_path, STATED), driven) as found:
        assert found.controller is not None
        assert not found.controller.fails


def test_recorded_input_voids_nothing(tmp_path: Path, driven: list[Recording]) -> None:
    with_it = [r.with_signals({"feedforward": np.zeros(len(r))}) for r in driven]
    with opened_parities(bench(tmp_path, FEEDFORWARD), with_it) as found:
        assert found.controller is not None
        assert not found.controller.fails


def test_input_that_one_recording_lacks_voids_all(
    tmp_path: Path, fed_forward: list[Recording]
) -> None:
    with_it = fed_forward[0].with_signals({"feedforward": np.full(len(fed_forward[0]), 0.2)})
    both = [with_it, replace(fed_forward[0], name="rec1.csv")]
    with opened_parities(bench(tmp_path, FEEDFORWARD), both) as found:
        assert found.controller is None
        assert "controller.feedforward" in found.why_not["controller"]


@pytest.mark.parametrize(
    ("removed", "name"),
    [('torque = "tau_load"', "tau_load"), ('command = "tau_command"', "tau_command")],
)
def test_input_of_the_plant_voids_nothing(tmp_path: Path, removed: str, name: str) -> None:
    """A load torque that was not recorded moves the plant, which the cut loop ignores."""
    twin = rewritten("servo_axis", tmp_path, {removed: ""})
    case = opened_with(twin, Axis().recordings({}, [multisine]))
    try:
        assert list(unrecorded_inputs(case)) == [name]
        found = parities(case, case.base)
        assert found.controller is not None
        assert not found.controller.fails
    finally:
        case.simulations.close()


def test_enabling_input_that_was_not_recorded_voids_the_parity(tmp_path: Path) -> None:
    """Without it, the drive may have been off for a while: no command is right then."""
    outputs = {'duty = "duty"': 'voltage = "voltage"\nduty = "duty"'}
    enabling = 'enabled = "enabled"                         # 0 opens the bridge\n'
    (tmp_path / "drive").mkdir()
    drive = rewritten("servo_pendulum", tmp_path / "drive", outputs)
    twin = rewritten("servo_pendulum", tmp_path, outputs | {enabling: ""})
    time = 5e-3 * np.arange(300, dtype=np.float64)
    on = np.where((time > 0.5) & (time < 0.8), 0.0, 1.0)
    signals = {"reference": multisine(time), "position": 0.0 * time, "enabled": on}
    run = drive.run({}, Recording(time=time, signals=signals))
    kept = {name: column for name, column in run.signals.items() if name != "enabled"}
    with opened_parities(twin, [replace(run, signals=kept)]) as found:
        assert found.controller is None
        assert "enabled" in found.why_not["controller"]


def test_check_says_which_input_is_missing(tmp_path: Path, fed_forward: list[Recording]) -> None:
    seen = check(bench(tmp_path), fed_forward, jobs=1)
    assert not [f for f in seen.findings if f.kind.startswith("controller")]
    told = " ".join(" ".join(check_lines(seen)).split())
    assert "controller: not checked: the controller also reads controller.feedforward" in told
    assert (
        'the twin leaves it at 0: if the drive did so, write "controller.feedforward" = 0' in told
    )
