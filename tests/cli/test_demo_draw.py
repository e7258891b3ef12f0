"""What the demo hides: the draw, the seal, the recordings and the judgement."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo import Recording
from gmfbo.cli.hidden.draw import NOTHING, PARAMETERS, Draw, draw
from gmfbo.cli.hidden.effects import EFFECTS
from gmfbo.cli.hidden.recordings import record
from gmfbo.cli.hidden.references import DURATION_S, SAMPLE_S, references
from gmfbo.cli.hidden.reveal import answer_lines, explained, judged
from gmfbo.cli.hidden.sealed import seal, unseal
from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.result.named_effect import IdentifiedValue, NamedEffect
from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.twin import FmuTwin
from tests.diagnosis.example_diagnoses import friction

QUICK = ("coulomb_friction", "cogging_torque", "backlash", "actuator_lag")
SEEDS = st.integers(min_value=0, max_value=2**40)


@pytest.fixture(scope="module")
def plant_parameters() -> set[str]:
    with FmuTwin(models_folder() / "demo_axis.toml") as axis:
        return set(axis.parameter_tunable())


def named(name: str, rivals: tuple[str, ...] = (), **values: float) -> NamedEffect:
    parameters = {key: IdentifiedValue(value, "1", value, value) for key, value in values.items()}
    return replace(
        friction().effects[0], name=name, indistinguishable_from=rivals, parameters=parameters
    )


def found(verdict: str, *effects: NamedEffect) -> Diagnosis:
    return replace(friction(), verdict=verdict, effects=effects)  # type: ignore[arg-type]


def hidden_effect(name: str) -> Draw:
    return next(one for one in map(draw, range(1000)) if one.hidden == name)


@given(SEEDS)
def test_a_seed_always_hides_the_same(seed: int) -> None:
    assert draw(seed) == draw(seed)


@given(SEEDS)
def test_every_draw_is_made_of_parameters_that_the_plant_has(
    plant_parameters: set[str], seed: int
) -> None:
    assert set(draw(seed).plant) <= plant_parameters


def test_all_effects_nothing_and_parameters_are_drawn_as_often_as_stated() -> None:
    """2000 seeds; five standard deviations of a binomial count: false alarm below 1 in 10^5."""
    counts = Counter(draw(seed).hidden for seed in range(2000))
    assert len(EFFECTS) >= 10
    shares = {NOTHING: 0.08, PARAMETERS: 0.08}
    shares |= {effect.name: 0.84 / len(EFFECTS) for effect in EFFECTS}
    assert set(counts) == set(shares)
    for name, share in shares.items():
        spread = np.sqrt(2000 * share * (1.0 - share))
        assert abs(counts[name] - 2000 * share) < 5.0 * spread


def test_hidden_effects_have_the_names_of_the_catalogue() -> None:
    assert {effect.name for effect in EFFECTS} <= set(CATALOGUE)


def test_the_twin_is_at_least_a_tenth_off_unless_nothing_is_hidden() -> None:
    for drawn in map(draw, range(300)):
        if drawn.hidden == NOTHING:
            assert not drawn.plant
        else:
            assert abs(np.log(drawn.plant["inertia"] / 0.01)) >= np.log(1.1)
            assert 0.005 < drawn.plant["inertia"] < 0.02  # where the twin file lets it be refitted


def test_the_sealed_hash_is_that_of_the_file_and_the_answer_comes_back(tmp_path: Path) -> None:
    drawn = draw(7)
    sealed = seal(drawn, tmp_path / "sealed.json")
    assert sealed.sha256 == hashlib.sha256(sealed.path.read_bytes()).hexdigest()
    assert unseal(sealed) == drawn
    assert json.loads(sealed.path.read_text())["hidden"] == drawn.hidden


def test_an_answer_that_was_changed_is_refused(tmp_path: Path) -> None:
    sealed = seal(draw(7), tmp_path / "sealed.json")
    seal(draw(8), sealed.path)
    with pytest.raises(InputError, match=r"expected the hash .* the answer was changed"):
        unseal(sealed)
    sealed.path.unlink()
    with pytest.raises(InputError, match=r"expected the sealed answer in .* run gmfbo demo again"):
        unseal(sealed)


def test_a_folder_that_takes_no_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"sealed\.json' cannot be written"):
        seal(draw(0), tmp_path / "nowhere" / "sealed.json")


def test_recordings_hold_what_a_logger_sees_and_nothing_of_the_draw(tmp_path: Path) -> None:
    drawn = hidden_effect("coulomb_friction")
    paths = record(drawn.plant, drawn.seed, tmp_path)
    assert [path.name for path in paths] == ["run0.csv", "run1.csv", "run2.csv", "run3.csv"]
    for path in paths:
        recording = Recording.read(path)
        assert set(recording.signals) == {"reference", "position", "torque_command"}
        assert not recording.parameters
        for word in ("friction", "coulomb", "seed", "inertia", repr(drawn.plant["inertia"])):
            assert word not in path.read_text()


def test_references_begin_at_rest_and_are_the_same_for_all() -> None:
    for wave in references():
        assert wave.shape == (round(DURATION_S / SAMPLE_S),)
        assert np.all(np.abs(wave[:50]) < 1e-9)
        assert np.ptp(wave) > 0.7


def recorded(plant: Mapping[str, float], folder: Path) -> list[Recording]:
    return [Recording.read(path) for path in record(plant, 0, folder)]


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(effect.name, marks=() if effect.name in QUICK else pytest.mark.slow)
        for effect in EFFECTS
    ],
)
def test_a_hidden_effect_shows_far_above_noise_and_does_not_lose_the_axis(
    name: str, tmp_path: Path
) -> None:
    """Against the same axis without it, in one recording at least; commands below the limit."""
    drawn = hidden_effect(name)
    rigid = {key: drawn.plant[key] for key in ("inertia", "viscous")}
    with_it, without = recorded(drawn.plant, tmp_path), recorded(rigid, tmp_path)
    command = [run.signal("torque_command") for run in with_it]
    off = [
        column - run.signal("torque_command") for column, run in zip(command, without, strict=True)
    ]
    noise = float(np.std(np.diff(without[0].signal("torque_command")[:90]))) / np.sqrt(2.0)
    assert max(float(np.sqrt(np.mean(column**2))) for column in off) > 2.0 * noise
    assert max(float(np.max(np.abs(column))) for column in command) < 9.9


@pytest.mark.parametrize(
    ("hidden", "diagnosis", "mark"),
    [
        (NOTHING, found("none"), "right"),
        (NOTHING, found("parameters"), "wrong"),
        (NOTHING, found("missing_physics", named("backlash")), "wrong"),
        (PARAMETERS, found("parameters"), "right"),
        (PARAMETERS, found("none"), "missed"),
        (PARAMETERS, found("outside_library"), "wrong"),
        ("backlash", found("missing_physics", named("backlash")), "right"),
        (
            "backlash",
            found("missing_physics", named("backlash", ("hysteresis",))),
            "one of the set",
        ),
        (
            "backlash",
            found("missing_physics", named("hysteresis", ("backlash",))),
            "one of the set",
        ),
        ("backlash", found("missing_physics", named("hysteresis")), "wrong"),
        (
            "backlash",
            found("missing_physics", named("backlash"), named("cogging_torque")),
            "wrong",
        ),
        ("backlash", found("parameters"), "missed"),
        ("backlash", found("outside_library"), "missed"),
    ],
)
def test_a_diagnosis_is_judged_without_mercy(hidden: str, diagnosis: Diagnosis, mark: str) -> None:
    drawn = Draw(0, hidden, {})
    assert judged(drawn, diagnosis) == mark
    assert explained(drawn, diagnosis).startswith(mark.upper())


def test_sizes_stand_beside_each_other_in_the_same_unit() -> None:
    drawn = Draw(0, "cogging_torque", {"ripple.torque": 0.5, "ripple.cycles": 12.0})
    effect = named("cogging_torque", sine_1=0.3, cosine_1=0.4, wavenumber_1=12.01)
    lines = answer_lines(drawn, found("missing_physics", effect))
    assert [line.split() for line in lines[2:4]] == [
        ["amplitude", "0.5", "N", "m", "0.5", "N", "m"],
        ["cycles", "a", "turn", "12", "12"],
    ]


def test_sizes_that_were_not_found_are_dashes() -> None:
    drawn = Draw(0, "backlash", {"gap": 0.01, "load.inertia": 0.004})
    lines = answer_lines(drawn, found("parameters"))
    assert [line.split()[-1] for line in lines[2:4]] == ["-", "-"]
    assert "found" in lines[0]
