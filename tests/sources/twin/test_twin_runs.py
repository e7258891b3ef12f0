"""Runs of a twin: what is driven, what is set, what comes out."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin, Recording, step_reference
from gmfbo.errors import InputError, RecordingError
from gmfbo.sources.fmu_file.models import models_folder
from tests.fmu_build.fmu_instance import FmuInstance, unpacked_fmu
from tests.sources.conftest import AXIS, FAULTY, LOOP, TEST_FMUS

if TYPE_CHECKING:
    from tests.sources.conftest import Repack, WriteTwin

ROWS = 301
TIME = 1e-3 * np.arange(ROWS, dtype=np.float64)
REFERENCE = 0.02 * np.sin(30.0 * TIME) ** 2
FOLLOWED = Recording(time=TIME, signals={"reference": REFERENCE}, name="rec.csv")


def by_hand(outputs: list[str], **values: float) -> NDArray[np.float64]:
    """Outputs of the linear axis at each communication point, stepped through plain fmpy."""
    with unpacked_fmu(models_folder() / "linear_axis.fmu") as folder:
        instance = FmuInstance(folder)
        instance.start(**values)
        table = instance.run({"reference": REFERENCE[:-1]}, outputs, 1e-3)
        instance.close()
    return table


def test_a_run_is_what_plain_fmpy_steps(axis: Path) -> None:
    expected = by_hand(["position", "drive_voltage"], kp=100.0, kv=200.0)
    with FmuTwin(axis) as twin:
        trajectory = twin.run((100.0, 200.0), FOLLOWED)
    assert trajectory.status == "ok"
    assert np.array_equal(trajectory.time, TIME)
    assert np.array_equal(trajectory.signal("position"), expected[:, 0])
    assert np.array_equal(trajectory.signal("drive_voltage"), expected[:, 1])
    assert np.array_equal(trajectory.signal("reference"), REFERENCE)
    assert trajectory.units == {"reference": "m", "position": "m", "drive_voltage": "V"}
    assert trajectory.parameters == {"kp": 100.0, "kv": 200.0}
    assert trajectory.message == ""
    assert trajectory.stopped_at is None
    assert trajectory.seconds > 0.0


def test_wired_controller_and_plant_follow_their_difference_equation(
    write_twin: WriteTwin,
) -> None:
    """m v' = u - d v under a held u has a closed form; u = kp (r - x) at each sample."""
    mass, friction, kp, step = 2.0, 60.0, 500.0, 1e-3
    decay = np.exp(-friction / mass * step)
    x, v, positions, forces = 0.0, 0.0, [0.0], []
    for r in REFERENCE[:-1]:
        u = kp * (r - x)
        forces.append(u)
        rest = v - u / friction
        x += u / friction * step + rest * mass / friction * (1.0 - decay)
        v = u / friction + rest * decay
        positions.append(x)
    with FmuTwin(write_twin(LOOP)) as twin:
        trajectory = twin.run({}, FOLLOWED)
    assert np.ptp(positions) > 5e-3
    np.testing.assert_allclose(trajectory.signal("position"), positions, atol=1e-9)
    np.testing.assert_allclose(trajectory.signal("force")[1:], forces, atol=1e-5)


def test_the_nearer_a_value_is_given_to_the_run_the_more_it_counts(write_twin: WriteTwin) -> None:
    """Twin file, recording, [initial], twin's parameters, run's parameters, gains."""

    def position(twin: FmuTwin, recorded: float, **given: float) -> float:
        held = np.full(3, 7.0)
        recording = Recording(
            time=TIME[:3], signals={"reference": held}, parameters={"gain": recorded}
        )
        named = {"gain": given["gains"]} if "gains" in given else {}
        over = {"gain": given["run"]} if "run" in given else {}
        return float(twin.run(named, recording, parameters=over).signal("position")[-1]) / 7.0

    text = FAULTY + "[parameters]\ngain = 2.0\n"
    path = write_twin(text, TEST_FMUS / "faulty.fmu")
    plain = Recording(time=TIME[:3], signals={"reference": np.full(3, 7.0)})
    with FmuTwin(path, isolated=False) as twin:
        assert twin.run({}, plain).signal("position")[-1] == 14.0
        assert position(twin, 3.0) == 3.0
        assert position(twin, 3.0, run=5.0) == 5.0
        assert position(twin, 3.0, run=5.0, gains=6.0) == 6.0
    with FmuTwin(path, isolated=False, parameters={"gain": 4.0}) as twin:
        assert position(twin, 3.0) == 4.0
        assert position(twin, 3.0, run=5.0) == 5.0
    initial = write_twin(text + "[initial]\ngain = 9.0\n", TEST_FMUS / "faulty.fmu")
    with FmuTwin(initial, isolated=False) as twin:
        assert position(twin, 3.0) == 9.0
        assert position(twin, 3.0, run=5.0) == 5.0


def test_an_fmu_bound_is_named_with_variable_bounds_and_value(axis: Path) -> None:
    with FmuTwin(axis, isolated=False) as twin:
        message = "parameter 'mass': expected a value within [1, 10000] kg, the FMU's bounds, got "
        with pytest.raises(InputError, match=re.escape(message + "0.5")):
            twin.run({}, FOLLOWED, parameters={"mass": 0.5})
        with pytest.raises(InputError, match=re.escape("within [0, 10000] s-1")):
            twin.run({"kp": -1.0}, FOLLOWED)
        with pytest.raises(InputError, match=r"got nan"):
            twin.run({"kp": float("nan")}, FOLLOWED)
        with pytest.raises(InputError, match=r"axis: no FMU parameter 'kpp'; did you mean 'kp'\?"):
            twin.run({"kpp": 1.0}, FOLLOWED)
        with pytest.raises(InputError, match=r"expected 2 gains \(kp, kv\)"):
            twin.run([1.0], FOLLOWED)


def test_a_recording_without_any_input_is_refused(axis: Path) -> None:
    foreign = Recording(time=TIME, signals={"ref": REFERENCE}, name="rec.csv")
    with (
        FmuTwin(axis, isolated=False) as twin,
        pytest.raises(
            RecordingError,
            match=re.escape(
                "rec.csv: expected at least one signal of [inputs] (reference) to drive 'axis', "
                "it holds ref"
            ),
        ),
    ):
        twin.run({}, foreign)


def test_a_reference_in_another_kind_of_unit_is_refused(axis: Path) -> None:
    turned = step_reference(unit="rad")
    with (
        FmuTwin(axis, isolated=False) as twin,
        pytest.raises(
            RecordingError, match="'reference': expected m, the unit of FMU input 'reference', got"
        ),
    ):
        twin.run({}, turned)


def test_an_input_that_a_recording_lacks_keeps_its_start_value(write_twin: WriteTwin) -> None:
    text = AXIS.replace("[outputs]", 'force = "port.force"\n[outputs]')
    with FmuTwin(write_twin(text), isolated=False) as twin:
        without = twin.run({}, FOLLOWED)
        zero = twin.run({}, FOLLOWED.with_signals({"force": np.zeros(ROWS)}))
        pushed = twin.run({}, FOLLOWED.with_signals({"force": np.full(ROWS, 50.0)}))
    assert "force" not in without.signals
    assert np.array_equal(without.signal("position"), zero.signal("position"))
    assert not np.allclose(without.signal("position"), pushed.signal("position"), atol=1e-5)


# ---- schedules ------------------------------------------------------------------------------


def test_a_schedule_acts_from_the_row_where_it_changes(axis: Path) -> None:
    friction = np.where(np.arange(ROWS) < 150, 200.0, 800.0)
    scheduled = Recording(
        time=TIME, signals={"reference": REFERENCE}, schedules={"viscous_friction": friction}
    )
    with FmuTwin(axis, isolated=False) as twin:
        trajectory = twin.run({}, scheduled)
        constant = twin.run({}, FOLLOWED, parameters={"viscous_friction": 200.0})
        overruled = twin.run({"viscous_friction": 200.0}, scheduled)
    position, same = trajectory.signal("position"), constant.signal("position")
    assert np.array_equal(position[:151], same[:151])
    assert not np.array_equal(position[151:160], same[151:160])
    assert np.array_equal(overruled.signal("position"), same)
    assert np.array_equal(trajectory.schedules["viscous_friction"], friction)


def test_a_parameter_that_is_not_tunable_may_be_recorded_but_not_change(axis: Path) -> None:
    constant = Recording(
        time=TIME,
        signals={"reference": REFERENCE},
        schedules={"initial_position": np.full(ROWS, 0.01)},
    )
    changing = Recording(
        time=TIME,
        signals={"reference": REFERENCE},
        schedules={"initial_position": np.where(TIME < 0.1995, 0.01, 0.02)},
        name="rec.csv",
    )
    with FmuTwin(axis, isolated=False) as twin:
        assert twin.run({}, constant).status == "ok"
        with pytest.raises(
            RecordingError,
            match=r"rec\.csv: parameter 'initial_position' changes at t = 0\.2 s, but the FMU decl",
        ):
            twin.run({}, changing)


def test_a_scheduled_value_outside_the_bounds_and_an_unknown_name_are_refused(axis: Path) -> None:
    signals = {"reference": REFERENCE}
    outside = np.where(TIME < 0.1, 100.0, 1e9)
    with FmuTwin(axis, isolated=False) as twin:
        with pytest.raises(InputError, match=re.escape("'kp': expected a value within [0, 10000]")):
            twin.run({}, Recording(time=TIME, signals=signals, schedules={"kp": outside}))
        with pytest.raises(RecordingError, match=r"no FMU parameter 'Kp'; did you mean 'kp'\?"):
            twin.run({}, Recording(time=TIME, signals=signals, parameters={"Kp": 1.0}))


# ---- starts, logging, units -----------------------------------------------------------------


def test_initial_values_come_from_the_first_row(write_twin: WriteTwin) -> None:
    text = AXIS + '[initial]\ninitial_position = "position"\n'
    recorded = FOLLOWED.with_signals({"position": np.full(ROWS, 0.015)})
    expected = by_hand(["position"], initial_position=0.015)
    with FmuTwin(write_twin(text), isolated=False) as twin:
        assert np.array_equal(twin.run({}, recorded).signal("position"), expected[:, 0])
        moved = twin.run({}, recorded, parameters={"initial_position": 0.0})
        assert moved.signal("position")[0] == 0.0
        blank = recorded.with_signals({"position": np.full(ROWS, np.nan)})
        with pytest.raises(RecordingError, match=r"\[initial\] needs the first value of 'posi"):
            twin.run({}, blank)


def test_a_reference_without_measured_signals_starts_at_rest_despite_initial(
    write_twin: WriteTwin, axis: Path
) -> None:
    with FmuTwin(axis, isolated=False) as plain:
        expected = plain.run({}, FOLLOWED).signal("position")
    for source in ('"position"', '"fit"'):
        text = AXIS + f"[initial]\ninitial_position = {source}\n"
        with FmuTwin(write_twin(text), isolated=False) as twin:
            assert np.array_equal(twin.run({}, FOLLOWED).signal("position"), expected)


def test_a_logger_of_the_new_command_stores_what_was_computed_at_its_row(
    write_twin: WriteTwin,
) -> None:
    """kv (kp (r - q) - dq), dq = (q_k - q_{k-2}) / 2h: row k from row k's own measurement."""
    new = AXIS.replace('"drive_voltage"\n', '{ variable = "drive_voltage", logged = "new" }\n')
    with FmuTwin(write_twin(new), isolated=False) as twin:
        trajectory = twin.run((100.0, 200.0), FOLLOWED)
    q = trajectory.signal("position")
    speed = (q[2:] - q[:-2]) / 2e-3
    command = 200.0 * (100.0 * (REFERENCE[2:] - q[2:]) - speed)
    logged = trajectory.signal("drive_voltage")
    np.testing.assert_allclose(logged[2:-1], np.clip(command, -10.0, 10.0)[:-1], atol=1e-6)
    assert logged[-1] == logged[-2]
    with FmuTwin(write_twin(AXIS), isolated=False) as twin:
        held = twin.run((100.0, 200.0), FOLLOWED).signal("drive_voltage")
    assert np.array_equal(logged[:-1], held[1:])


def test_outputs_and_inputs_are_si_whatever_the_fmu_counts_in(
    repack: Repack, write_twin: WriteTwin, axis: Path
) -> None:
    """The same binary, declared in millimetres: numbers stay, so SI shrinks by a thousand."""
    fmu = repack(
        edits={
            r'(name="(?:reference|position|initial_position)"[^/]*?<Real unit=)"m"': r'\1"mm"',
            "<UnitDefinitions>": '<UnitDefinitions><Unit name="mm">'
            '<BaseUnit m="1" factor="0.001"/></Unit>',
        }
    )
    text = AXIS + '[initial]\ninitial_position = "position"\n'
    start = {"position": np.full(ROWS, 0.004)}
    small = Recording(
        time=TIME, signals={"reference": 1e-3 * REFERENCE, "position": 1e-3 * start["position"]}
    )
    with FmuTwin(write_twin(text, fmu), isolated=False) as scaled:
        assert scaled.signal_specs()["position"].unit == "m"
        shrunk = scaled.run({}, small)
    with FmuTwin(write_twin(text), isolated=False) as plain:
        full = plain.run({}, FOLLOWED.with_signals(start))
    assert shrunk.units["position"] == "m"
    np.testing.assert_allclose(
        1e3 * shrunk.signal("position"), full.signal("position"), rtol=1e-9, atol=1e-15
    )
    np.testing.assert_allclose(
        shrunk.signal("drive_voltage"), full.signal("drive_voltage"), rtol=1e-6, atol=1e-9
    )


def test_a_jittered_clock_gives_the_run_of_an_even_one(axis: Path) -> None:
    rng = np.random.default_rng(0)
    late = 1e-8 * rng.uniform(0.0, 1.0, ROWS)
    late[0] = 0.0
    jittered = Recording(time=TIME + late, signals={"reference": REFERENCE})
    with FmuTwin(axis, isolated=False) as twin:
        even, uneven = twin.run({}, FOLLOWED), twin.run({}, jittered)
    assert np.array_equal(even.time, uneven.time)
    assert np.array_equal(even.signal("position"), uneven.signal("position"))


def test_a_recording_may_start_at_any_time(axis: Path) -> None:
    later = Recording(time=TIME + 17.25, signals={"reference": REFERENCE})
    with FmuTwin(axis, isolated=False) as twin:
        one, other = twin.run({}, FOLLOWED), twin.run({}, later)
    assert other.time[0] == 17.25
    np.testing.assert_allclose(other.signal("position"), one.signal("position"), atol=1e-12)


def test_a_finer_step_holds_the_reference_between_its_rows(axis: Path) -> None:
    with FmuTwin(axis, isolated=False) as coarse, FmuTwin(axis, isolated=False, step=2e-4) as fine:
        one, other = coarse.run({}, FOLLOWED), fine.run({}, FOLLOWED)
    assert len(other) == 5 * (ROWS - 1) + 1
    np.testing.assert_allclose(other.signal("position")[::5], one.signal("position"), atol=1e-12)


def test_linear_inputs_ramp_between_their_rows(write_twin: WriteTwin) -> None:
    text = FAULTY.replace('= "reference"', '= { variable = "reference", interpolation = "linear" }')
    coarse = Recording(time=np.array([0.0, 0.01]), signals={"reference": np.array([0.0, 1.0])})
    with FmuTwin(write_twin(text, TEST_FMUS / "faulty.fmu"), isolated=False) as twin:
        followed = twin.run({}, coarse).signal("position")
    np.testing.assert_allclose(followed, [0.0, *np.arange(10) / 10.0], atol=1e-15)


# ---- what a twin tells ----------------------------------------------------------------------


def test_signal_specs_tell_how_columns_become_signals(write_twin: WriteTwin) -> None:
    text = AXIS.replace(
        '= "drive_voltage"',
        '= { variable = "drive_voltage", column = "vir", scale = "force_gain", offset = "fit" }',
    ).replace('= "position"', '= { variable = "position", scale = 5e-8, offset = 0.25 }')
    with FmuTwin(write_twin(text + "[parameters]\nforce_gain = 30.0\n")) as twin:
        specs = twin.signal_specs()
        assert list(specs) == ["reference", "position", "drive_voltage"]
        assert (specs["position"].scale, specs["position"].offset) == (5e-8, 0.25)
        assert specs["drive_voltage"].column == "vir"
        assert (specs["drive_voltage"].scale, specs["drive_voltage"].offset) == (30.0, 0.0)
        assert specs["drive_voltage"].scaled
        assert not specs["reference"].scaled
    with FmuTwin(write_twin(text), parameters={"force_gain": 20.0}) as twin:
        assert twin.signal_specs()["drive_voltage"].scale == 20.0


def test_gains_are_the_twin_files_box_without_what_it_fixes(write_twin: WriteTwin) -> None:
    with FmuTwin(write_twin(AXIS.replace("[60.0, 500.0]", "200.0"))) as twin:
        assert twin.gains.names == ("kp",)
        assert twin.gains.bounds.tolist() == [[40.0], [320.0]]


def test_a_gain_that_the_file_fixes_is_in_force(write_twin: WriteTwin) -> None:
    with FmuTwin(write_twin(AXIS.replace("[60.0, 500.0]", "200.0")), isolated=False) as twin:
        fixed = twin.run([100.0], FOLLOWED).signal("position")
        other = twin.run({"kp": 100.0, "kv": 210.0}, FOLLOWED).signal("position")
    expected = by_hand(["position"], kp=100.0, kv=200.0)
    assert np.array_equal(fixed, expected[:, 0])
    assert not np.array_equal(other, fixed)


def test_the_content_hash_is_that_of_the_meaning(write_twin: WriteTwin, repack: Repack) -> None:
    def hash_of(text: str, fmu: Path | None = None, **more: float) -> str:
        return FmuTwin(write_twin(text, fmu), parameters=more or None).content_hash

    plain = hash_of(AXIS)
    assert plain == hash_of("# a comment\n" + AXIS.replace('"axis"', '"another name"'))
    assert plain == hash_of(AXIS.replace("step = 1e-3", "step = 0.001"))
    different = {
        hash_of(AXIS, mass=90.0),
        hash_of(AXIS.replace("step = 1e-3", "step = 2e-3")),
        hash_of(AXIS + "[parameters]\nmass = 90.0\n"),
        hash_of(AXIS, repack(edits={"Linear servo axis": "linear servo axis"})),
    }
    assert plain not in different
    assert len(different) == 4


def test_a_diverged_run_keeps_its_rows_and_its_time(write_twin: WriteTwin) -> None:
    with FmuTwin(write_twin(FAULTY, TEST_FMUS / "faulty.fmu"), isolated=False) as twin:
        trajectory = twin.run({}, FOLLOWED, parameters={"fault": 4, "at": 0.1})
    assert trajectory.status == "diverged"
    assert len(trajectory) == 101
    assert trajectory.stopped_at == pytest.approx(0.1)
    assert np.isfinite(trajectory.signal("position")).all()
    assert trajectory.signal("reference").size == 101


def test_a_failure_at_the_start_is_a_row_without_values(write_twin: WriteTwin) -> None:
    with FmuTwin(write_twin(FAULTY, TEST_FMUS / "faulty.fmu"), isolated=False) as twin:
        trajectory = twin.run({}, FOLLOWED, parameters={"fault": 6, "stage": 1})
    assert trajectory.status == "failed"
    assert trajectory.time.tolist() == [0.0]
    assert np.isnan(trajectory.signal("position")).all()


@pytest.mark.parametrize(("name", "value"), [("step", 0.0), ("step", np.inf), ("time_limit_s", 0)])
def test_times_have_to_be_positive(name: str, value: float, axis: Path) -> None:
    with pytest.raises(InputError, match=f"{name}: expected"):
        FmuTwin(axis, **{name: value})  # type: ignore[arg-type]
