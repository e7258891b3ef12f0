"""Calibration against closed forms: a model that is linear has a ridge solution."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.retuning.calibration import (
    EFFECTIVE_SAMPLES,
    Calibration,
    Estimate,
    RealRun,
    floors,
)
from gmfbo.retuning.unknowns import Scalar, Unknowns

Array = NDArray[np.float64]
NAMES = ("a", "b", "c")
UNKNOWNS = Unknowns(tuple(Scalar(name, 0.0, -8.0, 8.0) for name in NAMES))
SPREAD = 4.0  # a quarter of the range


class Linear:
    """Signals that are linear in three parameters, with a count of the simulations."""

    def __init__(self, seed: int, bent: float = 0.0) -> None:
        rng = np.random.default_rng(seed)
        self.design, self.bent, self.calls = rng.standard_normal((2, 150, 3)), bent, 0
        self.noise = 0.05 * rng.standard_normal((2, 150))

    def __call__(self, settings: dict[str, float]) -> Array:
        self.calls += 1
        values = np.array([settings[name] for name in NAMES])
        return np.asarray(self.design @ (values + self.bent * values**3))

    def run(self, number: int, truth: Array) -> RealRun:
        exact = self(dict(zip(NAMES, truth, strict=True)))
        return RealRun(number, exact + self.noise, self)


TRUTH = np.array([1.0, -2.0, 0.5])


def test_a_linear_model_gets_the_ridge_solution() -> None:
    models = [Linear(1), Linear(2)]
    runs = [model.run(k, TRUTH) for k, model in enumerate(models)]
    found = Calibration(UNKNOWNS, runs).estimate(Estimate.begin(UNKNOWNS, 2))
    normal, right = np.eye(3), np.zeros(3)
    for model, run in zip(models, runs, strict=True):
        for signal in range(2):
            weight = EFFECTIVE_SAMPLES / 150 / found.errors[signal] ** 2
            slope = SPREAD * model.design[signal]
            normal += weight * slope.T @ slope
            right += weight * slope.T @ run.measured[signal]
    assert found.x == pytest.approx(np.linalg.solve(normal, right), rel=1e-3)


def test_the_errors_are_the_noise() -> None:
    runs = [Linear(seed).run(seed, TRUTH) for seed in range(4)]
    found = Calibration(UNKNOWNS, runs).estimate(Estimate.begin(UNKNOWNS, 2))
    assert found.errors == pytest.approx([0.05, 0.05], rel=0.1)
    assert np.all(found.errors > floors(runs))


def test_a_bent_model_is_followed() -> None:
    runs = [Linear(seed, bent=0.05).run(seed, TRUTH) for seed in range(3)]
    found = Calibration(UNKNOWNS, runs).estimate(Estimate.begin(UNKNOWNS, 2))
    assert SPREAD * found.x == pytest.approx(TRUTH, abs=0.02)


def test_an_estimate_that_goes_on_costs_a_fraction_of_the_first() -> None:
    models = [Linear(seed, bent=0.02) for seed in range(4)]
    runs = [model.run(k, TRUTH) for k, model in enumerate(models)]
    first = Calibration(UNKNOWNS, runs[:3]).estimate(Estimate.begin(UNKNOWNS, 2))
    again = Calibration(UNKNOWNS, runs).estimate(first)
    assert again.x == pytest.approx(first.x, abs=0.02)
    assert again.simulations < 0.7 * first.simulations


def test_what_no_recording_sees_keeps_its_prior() -> None:
    model = Linear(5)
    model.design[:, :, 2] = 0.0
    found = Calibration(UNKNOWNS, [model.run(0, TRUTH)]).estimate(Estimate.begin(UNKNOWNS, 2))
    assert found.x[2] == pytest.approx(0.0, abs=1e-9)


def test_a_run_of_less_weight_moves_the_estimate_less() -> None:
    early, late = Linear(1).run(1, TRUTH + 1.0), Linear(2).run(2, TRUTH)
    from dataclasses import replace

    both = Calibration(UNKNOWNS, [early, late]).estimate(Estimate.begin(UNKNOWNS, 2))
    light = [replace(early, weight=0.01), late]
    aged = Calibration(UNKNOWNS, light).estimate(Estimate.begin(UNKNOWNS, 2))
    away = [float(np.linalg.norm(SPREAD * one.x - TRUTH)) for one in (aged, both)]
    assert away[0] < 0.1 * away[1]


def test_a_twin_that_fails_leaves_the_estimate_where_it_was() -> None:
    run = RealRun(1, np.zeros((2, 150)), lambda settings: None)
    begun = Estimate.begin(UNKNOWNS, 2)
    assert Calibration(UNKNOWNS, [run]).estimate(begun).x.tolist() == begun.x.tolist()


@pytest.mark.parametrize(
    "scalar", [Scalar("inertia", 0.01, 0.005, 0.02), Scalar("offset", 0.1, -1.0, 1.0)]
)
def test_place_undoes_value(scalar: Scalar) -> None:
    for x in (-1.0, 0.0, 0.7):
        assert scalar.place(scalar.value(x)) == pytest.approx(x)
    assert scalar.value(0.0) == pytest.approx(scalar.nominal)
    assert scalar.low <= scalar.value(-100.0) < scalar.value(100.0) <= scalar.high
