"""Each effect's parameters are recovered from recordings that the augmented twin made itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin
from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis, Setting
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.runs.measured_excitation import measure_ranges
from gmfbo.diagnosis.runs.scored_record import Record, scored_record
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.noise_levels import white_covariance
from gmfbo.diagnosis.scoring.whitening import Whitener, make_window
from gmfbo.physics import CATALOGUE
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.uncertain import Uncertain

TRUTH = {"inertia": 0.0105, "viscous": 0.03}
OWN = (Uncertain("inertia", 0.01, 0.005, 0.02), Uncertain("viscous", 0.02, 0.0, 0.2))
NOISE = {"position": 1e-6, "torque_command": 1e-4}
"""[rad], [N.m] Far below the recordings of a drive: errors left are the fit's own."""


@dataclass(frozen=True)
class Trial:
    """One effect at a typical size, and how its fit begins.

    Attributes
    ----------
    values : mapping of str to float
        True values.
    known : tuple of str
        Parameters of the twin that do the same as the effect, and hence are not free.
    near : mapping of str to float
        Parameters that start nearer to the truth than 25 %, as a factor: those that a search over
        lines or pulses gives to the fit.
    within : float
        Share of the true value by which an estimate may be off.
    """

    values: Mapping[str, float]
    known: tuple[str, ...] = ()
    near: Mapping[str, float] = field(default_factory=dict)
    within: float = 0.005


BOTH = ("inertia", "viscous")  # a gain in the loop scales the two alike
TRIALS = {
    "coulomb_friction": Trial({"level": 0.2}),
    "stribeck_friction": Trial({"level": 0.15, "breakaway": 0.3, "velocity": 0.3}),
    "presliding_friction": Trial({"level": 0.2, "deflection": 5e-3}),
    "asymmetric_friction": Trial(
        {"level_positive": 0.25, "level_negative": 0.15, "viscous_difference": 0.01}
    ),
    "load_dependent_friction": Trial({"coefficient": 0.08, "level": 0.1}),
    "position_dependent_friction": Trial(
        {"level": 0.2, "sine": 0.08, "cosine": 0.08, "wavenumber": 8.0}, near={"wavenumber": 1.05}
    ),
    "viscous_friction": Trial({"coefficient": 0.05}, known=("viscous",)),
    "quadratic_drag": Trial({"coefficient": 0.01}),
    "backlash": Trial({"gap": 2e-3, "load_inertia": 0.004}),
    "torsional_compliance": Trial({"stiffness": 80.0, "load_inertia": 0.004, "damping": 0.05}),
    "hysteresis": Trial({"level": 0.2, "deflection": 0.02}),
    "cogging_torque": Trial(
        {"sine_1": 0.1, "cosine_1": 0.08, "wavenumber_1": 28.0}, near={"wavenumber_1": 1.01}
    ),
    "torque_ripple": Trial(
        {"sine_1": 0.05, "cosine_1": 0.04, "wavenumber_1": 28.0}, near={"wavenumber_1": 1.01}
    ),
    "gravity_torque": Trial({"sine": 0.3, "cosine": 0.2}),
    "elastic_return": Trial({"stiffness": 0.5, "preload": 0.1}),
    "constant_torque_offset": Trial({"level": 0.2}),
    "actuator_saturation": Trial({"limit": 1.5}),
    "actuator_dead_zone": Trial({"width": 0.1}),
    "actuator_rate_limit": Trial({"rate": 600.0}),  # below 100 the loop cycles, and no fit holds
    "actuator_lag": Trial({"time": 2e-3}),
    "actuator_gain_loss": Trial({"loss": 0.1}, known=BOTH),
    "transport_delay": Trial({"delay": 2.3e-3}),
    "thermal_derating": Trial({"loss": 0.1, "time": 0.3}, known=BOTH),
    "supply_voltage_limit": Trial({"limit": 2.0, "slope": 0.2}),
    "magnetic_saturation": Trial({"coefficient": 0.1}),
    "sensor_eccentricity": Trial({"sine": 0.02, "cosine": 0.03}),
    "sensor_lag": Trial({"time": 2e-3}),
    "sensor_offset": Trial({"level": 0.02}),
    "sensor_scale": Trial({"share": 0.02}, known=BOTH),
    "periodic_disturbance": Trial(
        {"sine": 0.1, "cosine": 0.1, "frequency": 7.0}, near={"frequency": 1.02}
    ),
    "pulse_disturbance": Trial(
        {"level": 0.3, "start": 0.4, "duration": 0.2}, near={"start": 1.02, "duration": 1.1}
    ),
    "load_inertia": Trial({"inertia": 0.002}, known=("inertia",)),
}


def reference(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """A brisk multisine, then a step down that uses the whole command, and a sweep back."""
    tones = [(1.7, 0.3, 0.1), (4.3, 0.12, 2.0), (9.1, 0.03, 4.2)]
    wave = np.sum([a * np.sin(2.0 * np.pi * f * t + p) for f, a, p in tones], axis=0)
    wave *= np.clip(t / 0.1, 0.0, 1.0) * np.clip((0.62 - t) / 0.1, 0.0, 1.0)
    step: NDArray[np.float64] = wave - 0.15 * (t >= 0.62) + np.clip((t - 0.7) * 1.5, 0.0, 0.15)
    return step


@pytest.fixture(scope="module")
def axis() -> Iterator[Simulations]:
    twin = FmuTwin(models_folder() / "servo_axis.toml", parameters=TRUTH)
    time = np.arange(850, dtype=np.float64) * 1e-3
    with AugmentedTwin(twin, isolated=False) as first:
        asked = Recording(
            time=time,
            signals={"reference": reference(time)},
            name="own.csv",
            parameters={"kp": 40.0, "kd": 0.8},
        )
        plan = first.plan(asked, TRUTH)
        run = first.run(plan, TRUTH)
        record = scored_record(asked.with_signals(dict(run.held)), plan, list(NOISE), 0.0)
    with Simulations(lambda: AugmentedTwin(twin, isolated=False), [record], 1) as simulations:
        yield simulations


def recorded(axis: Simulations, truth: Point) -> Record:
    """Let the axis be measured at a point, with little noise."""
    rng = np.random.default_rng(1)
    simulated = axis.run([truth])[0][0]
    assert simulated.finite
    record = axis.records[0]
    signals = [
        replace(s, values=v + NOISE[s.name] * rng.standard_normal(v.size))
        for s, v in zip(record.signals, simulated.signals, strict=True)
    ]
    return replace(record, signals=tuple(signals))


def white_misfit(axis: Simulations) -> Misfit:
    """Misfit in units of the noise."""
    signals = axis.records[0].signals
    rows = [slice(0, s.values.size) for s in signals]
    window = make_window(0, [s.spacing for s in signals], rows)
    covariance = white_covariance(window, [NOISE[s.name] ** 2 for s in signals])
    return Misfit(axis, (Whitener(window, covariance),))


def setting_of(axis: Simulations, nominal: list[Simulated], known: tuple[str, ...]) -> Setting:
    excitation = measure_ranges(
        axis.records,
        nominal,
        torque=4.0,
        command=0.0,
        speed=None,
        step=1e-4,
        loop_time=0.03,
        resolution=1e-6,
        inertia=0.01,
        angular=True,
    )
    free = tuple(u for u in OWN if u.name not in known)
    return Setting(free, excitation, "inertia")


def test_every_effect_of_the_catalogue_is_tried() -> None:
    assert set(TRIALS) == set(CATALOGUE)


@pytest.mark.parametrize("name", list(TRIALS))
def test_its_parameters_are_recovered_from_its_own_simulation(axis: Simulations, name: str) -> None:
    trial = TRIALS[name]
    setting = setting_of(axis, axis.run([Point(TRUTH)])[0], trial.known)
    begun = {n: v * trial.near.get(n, 0.75) for n, v in trial.values.items()}
    true = Hypothesis(setting, (Candidate(name, trial.values),))
    start = Hypothesis(setting, (Candidate(name, begun),))
    originals = axis.records
    try:
        axis.replace_records([recorded(axis, true.point(true.start(TRUTH)))])
        found = fit(white_misfit(axis), start, {"inertia": 0.012, "viscous": 0.02}, iterations=25)
    finally:
        axis.replace_records(originals)
    assert found is not None
    assert found.chi2 / sum(block.size for block in found.residual) < 1.1
    for parameter, value in trial.values.items():
        estimate = found.hypothesis.effects[0].values[parameter]
        assert estimate == pytest.approx(value, rel=trial.within), (parameter, found.x)
