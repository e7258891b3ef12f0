"""Gains of the textbook: SIMC (Skogestad 2003) on a model identified from the first runs.

With T = tau_c + theta and tau_c = theta, theta the delay and one sample of hold and computation:

=============  =====================================================================
pd             double integrating: K_p = 1 / (4 b T^2), K_d = 1 / (b T)
cascade_p_p    the same loop as a cascade: k_v = 1 / (b T), k_p = 1 / (4 T)
cascade_p_pi   also k_i = k_v / (4 T); feed-forward of velocity 1, of friction a / b
pid            the series law K_c = 1 / (4 b T^2), tau_I = tau_D = 4 T as a parallel one
pi             first order by the half rule: K_c = tau / (K T), tau_I = min(tau, 4 T)
=============  =====================================================================
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.low_order.closed_loop import PlantModel
from gmfbo.tuning.methods.low_order.control_law import ControlLaw
from gmfbo.tuning.methods.low_order.identification import identify
from gmfbo.tuning.methods.low_order.runs import SampledRuns
from gmfbo.tuning.study.playing import play
from tests.benchmarks.plants.catalogue import PLANTS
from tests.benchmarks.plants.judge import Judge

Vector = NDArray[np.float64]

TWIN_RUNS = 60
"""Runs of the twin that the controller is read from."""


def by_rule(rule: str, plant: PlantModel, step: float) -> dict[str, float]:
    """Gains by their short names, lower case.

    Parameters
    ----------
    rule : str
        See the table above.
    plant : PlantModel
        One plant.
    step : float
        [s] Sample of the controller.
    """
    b, a, k = abs(plant.gain[0]), plant.damping[0], plant.stiffness[0]
    theta = plant.delay[0] + step
    T = 2.0 * theta
    if rule == "pi":
        return _pi(b, a, k, theta)
    single = 1.0 / (4.0 * b * T**2)
    if rule == "pd":
        return {"kp": single, "kd": 1.0 / (b * T)}
    if rule == "pid":
        return {"kp": 2.0 * single, "ki": single / (4.0 * T), "kd": single * 4.0 * T}
    gains = {"kv": 1.0 / (b * T), "kp": 1.0 / (4.0 * T)}
    if rule == "cascade_p_pi":
        gains |= {"ki": gains["kv"] / (4.0 * T)}
        gains |= {"velocity_feedforward_gain": 1.0, "feedforward_gain": a / b}
    return gains


def _pi(b: float, a: float, k: float, theta: float) -> dict[str, float]:
    if k <= 1e-9 * a * a:  # integrating, with a lag of 1 / a
        T = 2.0 * (theta + 1.0 / a)
        gain, time = a / (b * T), 4.0 * T
        return {"kp": gain, "ki": gain / time}
    slow, fast = sorted(abs(root) for root in np.roots([1.0, a, k]))
    theta += 0.5 / fast
    tau, T = 1.0 / slow + 0.5 / fast, 2.0 * theta
    gain = tau / (b / k * T)
    return {"kp": gain, "ki": gain / min(tau, 4.0 * T)}


def rule_gains(name: str, recordings: Sequence[Recording], state: TuningState) -> Vector:
    """Gains of a study's first real runs in the unit cube, shape (d,); those in force without any.

    Parameters
    ----------
    name : str
        Of the plant.
    recordings : sequence of Recording
        First real runs that ended well.
    state : TuningState
        With the twin's runs.
    """
    first = state.of("IS1")[0].point
    kept = {id(recording) for recording in recordings}
    twin = SampledRuns.of([t for t in state.trials if t.source == "IS2"], state)
    real = SampledRuns.of([t for t in state.trials if id(t.recording) in kept], state)
    if twin is None or real is None or not PLANTS[name].rule:
        return first
    law = ControlLaw.read(twin)
    if not law.is_read:
        return first
    found = by_rule(PLANTS[name].rule, identify(law, real).plant, real.step)
    now = state.space.from_unit(first)
    point = [_named(found, n, v) for n, v in zip(state.space.names, now, strict=True)]
    return np.clip(state.space.to_unit(np.clip(point, *state.space.bounds)), 0.0, 1.0)


def quiet_rule_gains(judge: Judge) -> Vector | None:
    """Gains of a noise-free run at the gains in force, shape (d,) [unit of each].

    Parameters
    ----------
    judge : Judge
        Of the plant.

    Returns
    -------
    ndarray or None
        None where no rule fits, or the controller could not be read.
    """
    rule, space = judge.plant.rule, judge.gains.space
    if not rule:
        return None
    points = space.latin_hypercube(TWIN_RUNS, np.random.default_rng(0))
    twin = _sampled(judge, points, twin=True)
    law = ControlLaw.read(twin)
    if not law.is_read:
        return None
    real = _sampled(judge, judge.in_force[None, :], twin=False)
    found = by_rule(rule, identify(law, real).plant, real.step)
    point = [_named(found, n, v) for n, v in zip(space.names, judge.in_force, strict=True)]
    return np.clip(point, *space.bounds)


def _sampled(judge: Judge, points: Vector, *, twin: bool) -> SampledRuns:
    source = judge.sources.is2 if twin else judge.axis
    signal, command = judge.experiment.signal, str(judge.experiment.terms.command)
    runs = [play(source, judge.gains.values(point), judge.experiment) for point in points]
    good = [k for k, run in enumerate(runs) if command in run.signals and len(run) == len(runs[0])]
    time = runs[good[0]].time
    return SampledRuns(
        time,
        points[good] / np.abs(judge.gains.space.bounds).max(axis=0),
        np.tile(judge.experiment.parts[0].target(time), (len(good), 1)),
        np.stack([runs[k].signal(signal) for k in good]),
        np.stack([runs[k].signal(command) for k in good]),
    )


def _named(found: dict[str, float], name: str, now: float) -> float:
    """Value of a gain by the rule; one that the rule does not name stays as it is."""
    return found.get(name.rpartition(".")[2].lower(), now)
