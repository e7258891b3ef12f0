"""Coast-downs of a bench whose log begins somewhere, at some speed: `[initial] NAME = "fit"`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, check, diagnose, models_folder
from gmfbo.diagnosis.case.open_case import open_case, open_unseen
from gmfbo.errors import InputError, RecordingError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

NOISE = 3e-5  # [rad]
STARTS = [(0.1, 20.0), (0.5, -30.0), (-0.3, 12.0)]  # [rad], [rad/s]
VISCOUS, LEVEL = 0.02, 0.03  # [N.m.s/rad], [N.m]
FIT = {"initial_position": "fit", "initial_velocity": "fit"}


def bench(initial: Mapping[str, str | float] = FIT) -> FmuTwin:
    twin = FmuTwin(models_folder() / "motor_bench.toml")
    changed = twin.with_file(twin.file.model_copy(update={"initial": dict(initial)}))
    return changed.with_uncertain({"viscous": (0.0, 0.08)})


def coast_downs(physics: Mapping[str, float], seed: int = 3) -> list[Recording]:
    rng, time = np.random.default_rng(seed), np.arange(1400, dtype=np.float64) * 1e-3
    off = np.zeros(time.size)
    made = []
    with bench() as twin, AugmentedTwin(twin, substeps=10, isolated=False) as simulator:
        for k, (position, velocity) in enumerate(STARTS):
            truth = {
                "viscous": VISCOUS,
                "initial_position": position,
                "initial_velocity": velocity,
            }
            asked = Recording(time=time, signals={"current": off}, written_by="test")
            run = simulator.run(simulator.plan(asked, truth), truth, physics)
            seen = run.held["position"] + NOISE * rng.standard_normal(time.size)
            signals = {"current": off, "position": seen}
            made.append(
                Recording(time=time, signals=signals, name=f"rec{k}.csv", written_by="test")
            )
    return made


def test_starts_and_friction_are_found_together() -> None:
    with (
        bench() as twin,
        closing((case := open_case(twin, coast_downs({}), seed=0, jobs=1)).simulations),
    ):
        position, velocity = case.simulations.starts
        assert case.base.parameters["viscous"] == pytest.approx(VISCOUS, rel=1e-3)
        # The first fit forgives 0.05 % of a position's range, which is 10 rad here.
        assert position.values == pytest.approx([p for p, _ in STARTS], abs=1e-3)
        assert velocity.values == pytest.approx([v for _, v in STARTS], abs=1e-2)
        unseen = open_unseen(case, coast_downs({}, seed=4), seed=0, jobs=1)
        with closing(unseen.simulations):
            assert unseen.simulations.starts[1].values == pytest.approx(velocity.values, abs=1e-2)


@pytest.mark.parametrize(("count", "within"), [(0.15, 0.15), (0.05, 0.02)])
def test_coarse_counts_tell_a_start_as_well_as_their_rounding_lets_them(
    count: float, within: float
) -> None:
    """A potentiometer of few steps: most rows are the row before, and no noise shows."""
    recordings = [
        one.with_signals({"position": count * np.round(one.signals["position"] / count)})
        for one in coast_downs({})
    ]
    with (
        bench() as twin,
        closing((case := open_case(twin, recordings, seed=0, jobs=1)).simulations),
    ):
        position, velocity = case.simulations.starts
        assert position.values == pytest.approx([p for p, _ in STARTS], abs=count)
        assert velocity.values == pytest.approx([v for _, v in STARTS], rel=within)
        assert case.base.parameters["viscous"] == pytest.approx(VISCOUS, rel=0.01)


def test_friction_that_the_twin_lacks_is_named_and_the_table_begins_where_the_axis_did() -> None:
    with bench() as twin:
        found = diagnose(twin, coast_downs({"coulomb_friction.level": LEVEL}), seed=0)
    (effect,) = found.effects
    assert effect.name == "coulomb_friction"
    assert effect.parameters["level"].low <= LEVEL <= effect.parameters["level"].high
    position = found.fit.signals["position"]
    assert position.augmented < 1.5 * position.noise_floor < 0.01 * position.parameters_only
    (note,) = [n for n in found.notes if n.startswith("[initial] initial_velocity was fitted")]
    assert "20 rad/s (rec0.csv), -30 rad/s (rec1.csv), 12 rad/s (rec2.csv)" in note
    # A current of nothing had been told to answer noise by 100 %.
    assert not [n for n in found.notes if "answers noise" in n]


def test_a_check_starts_where_the_first_rows_do() -> None:
    """Over a whole recording a twin with other friction would ask for another start."""
    with bench() as twin:
        seen = check(twin, coast_downs({}), seed=0)
    (note,) = [n for n in seen.notes if n.startswith("[initial] initial_position was fitted")]
    assert "0.1 rad (rec0.csv), 0.5 rad (rec1.csv), -0.3 rad (rec2.csv)" in note


def test_a_start_needs_rows_that_tell_it() -> None:
    recordings = coast_downs({})
    blank = np.where(recordings[1].time < 0.2, np.nan, recordings[1].signals["position"])
    recordings[1] = recordings[1].with_signals({"position": blank})
    with (
        bench() as twin,
        pytest.raises(RecordingError, match=r"rec1\.csv.*its first 0\.19 s are blank; cut them"),
    ):
        open_case(twin, recordings, seed=0, jobs=1)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("[uncertain]", '"initial_velocity" = [-50.0, 50.0]'),
        ("[parameters]", '"initial_velocity" = 5.0'),
        ("[fixed]", 'names = ["initial_*"]'),
    ],
)
def test_a_start_of_which_something_else_is_said_is_refused(
    table: str, said: str, tmp_path: Path
) -> None:
    text = (models_folder() / "motor_bench.toml").read_text(encoding="utf-8")
    fmu = (models_folder() / "motor_bench.fmu").as_posix()
    text = text.replace("motor_bench.fmu", fmu)
    text = text.replace("[initial]", '[initial]\n"initial_velocity" = "fit"')
    if table in text:
        text = text.replace(table, f"{table}\n{said}")
    else:
        text += f"\n{table}\n{said}\n"
    path = tmp_path / "twin.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=rf"{re.escape(table)} both say what it is: remove one"):
        FmuTwin(path)


def test_a_start_moves_an_axis_no_further_than_its_noise_needs() -> None:
    """A step of a hundredth of the range breaks it loose of its friction, and is no slope."""
    with (
        bench() as twin,
        closing(open_case(twin, coast_downs({}), seed=0, jobs=1).simulations) as s,
    ):
        position, _ = s.starts
    assert 1e-5 * position.spread <= position.step < 1e-3 * position.spread


def test_a_start_that_moves_nothing_recorded_is_refused() -> None:
    with (
        bench({"initial_logged_current": "fit"}) as twin,
        pytest.raises(RecordingError, match="initial_logged_current moves none; give a number"),
    ):
        open_case(twin, coast_downs({}), seed=0, jobs=1)
