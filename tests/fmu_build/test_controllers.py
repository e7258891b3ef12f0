"""Each controller FMU against the difference equation it is documented by, written in Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

Signals = dict[str, NDArray[np.float64]]
Gains = dict[str, float]


class FilteredDifference:
    """d_k = (T_f d_{k-1} + x_k - x_{k-1}) / (T_f + T_s), with x_{-1} = x_0 and d_{-1} = 0."""

    def __init__(self, gains: Gains) -> None:
        self.filter_time, self.sample_time = gains["filter_time"], gains["sample_time"]
        self.previous: float | None = None
        self.value = 0.0

    def __call__(self, x: float) -> float:
        change = 0.0 if self.previous is None else x - self.previous
        total = self.filter_time + self.sample_time
        self.value = (self.filter_time * self.value + change) / total
        self.previous = x
        return self.value


def pd_filtered(gains: Gains, signals: Signals) -> list[float]:
    difference, commands = FilteredDifference(gains), []
    measured = signals["measured_load" if gains["feedback_from_load"] else "measured"]
    for r, y, f in zip(signals["reference"], measured, signals["feedforward"], strict=True):
        d = difference(gains["derivative_weight"] * r - y)
        raw = gains["kp"] * (r - y) + gains["kd"] * d + gains["feedforward_gain"] * f
        commands.append(float(np.clip(raw, gains["u_min"], gains["u_max"])))
    return commands


def pid(gains: Gains, signals: Signals) -> list[float]:
    difference, integral, commands = FilteredDifference(gains), 0.0, []
    measured = signals["measured_load" if gains["feedback_from_load"] else "measured"]
    rate = min(gains["anti_windup_gain"], 1.0 / gains["sample_time"])
    for r, y, f in zip(signals["reference"], measured, signals["feedforward"], strict=True):
        d = difference(gains["derivative_weight"] * r - y)
        raw = gains["kp"] * (gains["proportional_weight"] * r - y) + integral
        raw += gains["kd"] * d + gains["feedforward_gain"] * f
        u = float(np.clip(raw, gains["u_min"], gains["u_max"]))
        integral += gains["sample_time"] * (gains["ki"] * (r - y) + rate * (u - raw))
        commands.append(u)
    return commands


def cascade_p_pi(gains: Gains, signals: Signals) -> list[float]:
    difference, integral, commands = FilteredDifference(gains), 0.0, []
    outer = signals["measured_load" if gains["position_from_load"] else "measured"]
    inner = signals["measured_load" if gains["velocity_from_load"] else "measured"]
    rate = min(gains["anti_windup_gain"], 1.0 / gains["sample_time"])
    limit = gains["velocity_limit"]
    for r, y, x, f in zip(signals["reference"], outer, inner, signals["feedforward"], strict=True):
        wanted = gains["kp"] * (r - y) + gains["velocity_feedforward_gain"] * f
        error = float(np.clip(wanted, -limit, limit)) - difference(x)
        raw = gains["kv"] * error + integral + gains["feedforward_gain"] * f
        u = float(np.clip(raw, gains["u_min"], gains["u_max"]))
        integral += gains["sample_time"] * (gains["ki"] * error + rate * (u - raw))
        commands.append(u)
    return commands


def gains_of(*names: str) -> st.SearchStrategy[Gains]:
    choices = {name: st.floats(0.0, 20.0) for name in names}
    choices |= {
        "filter_time": st.sampled_from([0.0, 1e-3, 2e-2]),
        "u_min": st.floats(-8.0, -1.0),
        "u_max": st.floats(1.0, 8.0),
        "sample_time": st.sampled_from([1e-3, 2.5e-4]),
        "feedforward_gain": st.floats(-2.0, 2.0),
    }
    return st.fixed_dictionaries(choices)


FLAG = st.sampled_from([0, 1])
WEIGHT = st.floats(0.0, 1.0)
CASES: dict[str, tuple[Callable[[Gains, Signals], list[float]], st.SearchStrategy[Gains]]] = {
    "pd_filtered": (
        pd_filtered,
        st.builds(
            lambda gains, flag, weight: (
                gains
                | {
                    "kd": gains["kd"] / 100.0,
                    "feedback_from_load": flag,
                    "derivative_weight": weight,
                }
            ),
            gains_of("kp", "kd"),
            FLAG,
            WEIGHT,
        ),
    ),
    "pid": (
        pid,
        st.builds(
            lambda gains, flag, first, second: (
                gains
                | {
                    "kd": gains["kd"] / 100.0,
                    "feedback_from_load": flag,
                    "derivative_weight": first,
                    "proportional_weight": second,
                    "anti_windup_gain": 1e3 * gains["anti_windup_gain"],
                }
            ),
            gains_of("kp", "ki", "kd", "anti_windup_gain"),
            FLAG,
            WEIGHT,
            WEIGHT,
        ),
    ),
    "cascade_p_pi": (
        cascade_p_pi,
        st.builds(
            lambda gains, outer, inner: (
                gains | {"position_from_load": outer, "velocity_from_load": inner}
            ),
            gains_of("kp", "kv", "ki", "anti_windup_gain", "velocity_limit").flatmap(
                lambda gains: st.just(gains | {"velocity_feedforward_gain": 0.5})
            ),
            FLAG,
            FLAG,
        ),
    ),
}


@pytest.mark.parametrize("name", sorted(CASES))
@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data(), seed=st.integers(0, 1000))
def test_the_fmu_computes_its_difference_equation(
    new_instance: NewInstance, name: str, data: st.DataObject, seed: int
) -> None:
    expected_of, strategy = CASES[name]
    gains = data.draw(strategy)
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.normal(size=(4, 60)), axis=1) * 0.1
    names = ("reference", "measured", "measured_load", "feedforward")
    signals = dict(zip(names, walk, strict=True))
    controller = new_instance(name).start(**gains)
    commands = controller.run(signals, ["u"], gains["sample_time"])[1:, 0]
    np.testing.assert_allclose(commands, expected_of(gains, signals), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", sorted(CASES))
def test_the_command_is_held_between_samples(new_instance: NewInstance, name: str) -> None:
    controller = new_instance(name).start(sample_time=2e-3, kp=3.0)
    signals: Signals = {"reference": np.linspace(1.0, 20.0, 20)}
    commands = controller.run(signals, ["u"], 1e-3)[1:, 0]
    np.testing.assert_array_equal(commands[0::2], commands[1::2])
    assert np.all(np.diff(commands[0::2]) > 0.0)


def test_anti_windup_shortens_the_way_back(new_instance: NewInstance) -> None:
    """After 0.5 s in the limit, the tracked integral leaves it within a few samples."""
    signals = {"reference": np.concatenate([np.full(500, 1.0), np.full(500, -1.0)])}
    left = {}
    for rate in (0.0, 1e3):
        controller = new_instance("pid").start(
            kp=1.0, ki=50.0, u_min=-1.5, u_max=1.5, anti_windup_gain=rate
        )
        commands = controller.run(signals, ["u"], 1e-3)[501:, 0]
        left[rate] = int(np.argmax(commands < 1.5))
    assert left[1e3] == 0
    assert left[0.0] > 300


def test_far_from_its_limits_the_pid_is_the_sum_of_its_three_parts(
    new_instance: NewInstance,
) -> None:
    """On the ramp r = t: k_p t + k_i (t^2 - t T_s) / 2 (forward Euler) + k_d."""
    t = np.linspace(0.0, 0.399, 400)
    controller = new_instance("pid").start(kp=2.0, ki=3.0, kd=0.5, derivative_weight=1.0)
    u = controller.run({"reference": t}, ["u"], 1e-3)[1:, 0]
    expected = 2.0 * t + 1.5 * (t**2 - t * 1e-3) + 0.5
    np.testing.assert_allclose(u[1:], expected[1:], rtol=1e-10)
