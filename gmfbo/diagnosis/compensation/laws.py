"""Tables that cancel each effect: its catalogue law with the opposite sign."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.compensation.table import CompensationTable
from gmfbo.diagnosis.result.predictions import Span
from gmfbo.physics import CATALOGUE, States

Column = NDArray[np.float64]
Values = Mapping[str, float]

REST_SHARE = 0.01
"""Of the fastest recorded motion: half width over which the sign of the velocity is smoothed."""

_BEYOND = 1.25  # of the recorded range, up to which a law is tabulated
_STRIBECK_SHARE = 0.1  # of the Stribeck velocity: widest smoothing allowed
_CURVE_NODES = 40  # of each direction, over the logarithm of the speed
_CYCLE_NODES = 256  # straight lines between them are 0.008 % of the amplitude off a sine
_FINEST_CYCLE = 64  # nodes a cycle where a table spans the recorded range: 0.12 % off


@dataclass(frozen=True)
class Ground:
    """Ranges and units over which laws are tabulated.

    Attributes
    ----------
    spans : mapping of str to Span
        Recorded range of each state.
    rest : float
        [velocity] Half width over which the sign of the velocity is smoothed.
    units : mapping of str to str
        Of each state and target.
    """

    spans: Mapping[str, Span]
    rest: float
    units: Mapping[str, str] = field(default_factory=dict)

    def largest(self, state: str) -> float:
        """Largest magnitude of a state that a table covers."""
        span = self.spans[state]
        return _BEYOND * max(abs(span.low), abs(span.high), 1e-12)

    def table(
        self, effect: str, target: str, over: str, x: Column, y: Column, **more: str | float
    ) -> CompensationTable:
        """Table in the units of this twin; `unit_y` is given where a factor changes it."""
        units = {"unit_x": self.units[over], "unit_y": self.units[target]}
        return CompensationTable(effect, target, over, x, y, **{**units, **more})  # type: ignore[arg-type]


Law = Callable[[str, Values, Ground], list[CompensationTable]]


def compensating_tables(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    """Tables that cancel an effect; none where no feed-forward can.

    Parameters
    ----------
    effect : str
        Name in the catalogue.
    values : mapping of str to float
        Its parameters.
    ground : Ground
        Ranges and units of the tables.
    """
    law = _LAWS.get(effect)
    return [] if law is None else law(effect, values, ground)


def _added(effect: str, values: Values, count: int, **columns: Column | float) -> Column:
    """Signal that an effect adds to its port at `count` given instants."""
    made = {
        name: np.full(count, 0.0) + columns.get(name, 0.0)
        for name in ("position", "velocity", "command", "current", "load_torque")
    }
    signal = CATALOGUE[effect].signal
    assert signal is not None, "it has motion of its own"
    rest = float(np.max(columns.get("rest", 0.0)))
    return signal(States(time=np.arange(count, dtype=np.float64), rest=rest, **made), values)


# ---- over velocity ------------------------------------------------------------------------------


def _jump(rest: float, ground: Ground) -> Column:
    largest = max(ground.largest("velocity"), 2.0 * rest)
    return np.array([-largest, -rest, rest, largest])


def _curve(rest: float, ground: Ground) -> Column:
    largest = max(ground.largest("velocity"), 2.0 * rest)
    one_way = np.geomspace(rest, largest, _CURVE_NODES)
    return np.concatenate([-one_way[::-1], [0.0], one_way])


def _straight(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    """Friction by direction of motion: a constant and a term linear in speed."""
    x = np.sort(np.append(_jump(ground.rest, ground), 0.0))
    y = -_added(effect, values, x.size, velocity=x, rest=ground.rest)
    return [ground.table(effect, "torque", "velocity", x, y)]


def _curved(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    rest = ground.rest
    if "velocity" in values:
        rest = min(rest, _STRIBECK_SHARE * values["velocity"])
    x = _curve(rest, ground)
    y = -_added(effect, values, x.size, velocity=x, rest=rest)
    return [ground.table(effect, "torque", "velocity", x, y)]


def _sliding(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    x = _jump(ground.rest, ground)
    y = values["level"] * np.sign(x)
    remark = "what it gives before it slides is not cancelled: only the level while sliding is"
    return [ground.table(effect, "torque", "velocity", x, y, remark=remark)]


def _loaded(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    x = _jump(ground.rest, ground)
    level, slope = values["level"] * np.sign(x), values["coefficient"] * np.sign(x)
    unit = _ratio(ground.units["torque"], ground.units["load"])
    more = {"factor": "load", "unit_y": unit}
    tables = [ground.table(effect, "torque", "velocity", x, slope, **more)]
    if values["level"]:
        tables.insert(0, ground.table(effect, "torque", "velocity", x, level))
    return tables


def _constant(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    x = _jump(ground.rest, ground)[[0, -1]]
    return [ground.table(effect, "torque", "velocity", x, np.full(2, -values["level"]))]


def _gap(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    """Backlash: the motor leads the load by half the gap in the direction of its push."""
    x = _jump(ground.rest, ground)
    remark = (
        "the load crosses the gap in its own time: move slowly through reversals, or let the "
        "offset rise over some milliseconds"
    )
    y = 0.5 * values["gap"] * np.sign(x)
    return [ground.table(effect, "reference", "velocity", x, y, remark=remark)]


# ---- over position ------------------------------------------------------------------------------


def _lines(values: Values) -> list[float]:
    return [
        value
        for name, value in values.items()
        if name.startswith("wavenumber") and value and _has_size(values, name)
    ]


def _has_size(values: Values, wavenumber: str) -> bool:
    tail = wavenumber.removeprefix("wavenumber")
    return bool(values.get(f"sine{tail}", 0.0) or values.get(f"cosine{tail}", 0.0))


def _places(lines: list[float], ground: Ground) -> tuple[Column, float]:
    """Nodes over one period of a single line, else over the recorded range."""
    if len(lines) == 1:
        period = 2.0 * np.pi / lines[0]
        return np.linspace(0.0, period, _CYCLE_NODES + 1), period
    span = ground.spans["position"]
    cycles = max(lines, default=0.0) * (span.high - span.low) / (2.0 * np.pi)
    count = max(2, int(np.ceil(_FINEST_CYCLE * cycles)) + 1)
    return np.linspace(span.low, span.high, count), 0.0


def _repeating(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    x, period = _places(_lines(values), ground)
    y = -_added(effect, values, x.size, position=x)
    return [ground.table(effect, "torque", "position", x, y, period=period)]


def _gravity(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    x, period = _places([1.0], ground)
    y = -_added(effect, values, x.size, position=x)
    return [ground.table(effect, "torque", "position", x, y, period=period)]


def _ripple(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    x, period = _places(_lines(values), ground)
    y = -_added(effect, values, x.size, position=x, current=1.0)
    unit = _ratio(ground.units["torque"], ground.units["current"])
    remark = "the current is that before the correction; the square of the ripple is left"
    more = {"factor": "current", "unit_y": unit, "remark": remark}
    return [ground.table(effect, "torque", "position", x, y, period=period, **more)]


def _spring(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    span = ground.spans["position"]
    x = np.array([span.low, span.high])
    y = -_added(effect, values, x.size, position=x)
    return [ground.table(effect, "torque", "position", x, y)]


def _tight_spots(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    x, period = _places(_lines(values) or [values["wavenumber"]], ground)
    y = -_added(effect, values, x.size, position=x, velocity=1.0)
    more: dict[str, str | float] = {"factor": "direction", "rest": ground.rest}
    return [ground.table(effect, "torque", "position", x, y, period=period, **more)]


# ---- over acceleration and command --------------------------------------------------------------


def _inertia(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    y = ground.largest("torque") * np.array([-1.0, 1.0])
    x = y / values["inertia"]
    return [ground.table(effect, "torque", "acceleration", x, y)]


def _dead_zone(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    largest = ground.largest("command")
    x = np.array([-largest, -REST_SHARE * largest, REST_SHARE * largest, largest])
    y = values["width"] * np.sign(x)
    return [ground.table(effect, "command", "command", x, y)]


def _gain(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    x = ground.largest("command") * np.array([-1.0, 1.0])
    y = x * values["loss"] / (1.0 - values["loss"])
    return [ground.table(effect, "command", "command", x, y)]


def _saturating_iron(effect: str, values: Values, ground: Ground) -> list[CompensationTable]:
    """Inverse of u / (1 + (c u)^2), which reaches its largest value 1 / (2 c) at u = 1 / c."""
    c = values["coefficient"]
    largest = min(ground.largest("command"), 0.5 / c)
    x = np.linspace(-largest, largest, 2 * _CURVE_NODES + 1)
    # The form without a difference of nearly equal numbers; no division by u = 0.
    whole = 2.0 * x / (1.0 + np.sqrt(np.maximum(0.0, 1.0 - (2.0 * c * x) ** 2)))
    return [ground.table(effect, "command", "command", x, whole - x)]


def _ratio(above: str, below: str) -> str:
    return "1" if above == below else f"{above}/{f'({below})' if '.' in below else below}"


_LAWS: Mapping[str, Law] = {
    "coulomb_friction": _straight,
    "asymmetric_friction": _straight,
    "stribeck_friction": _curved,
    "viscous_friction": _straight,
    "quadratic_drag": _curved,
    "presliding_friction": _sliding,
    "hysteresis": _sliding,
    "load_dependent_friction": _loaded,
    "position_dependent_friction": _tight_spots,
    "backlash": _gap,
    "cogging_torque": _repeating,
    "torque_ripple": _ripple,
    "gravity_torque": _gravity,
    "elastic_return": _spring,
    "constant_torque_offset": _constant,
    "load_inertia": _inertia,
    "actuator_dead_zone": _dead_zone,
    "actuator_gain_loss": _gain,
    "magnetic_saturation": _saturating_iron,
}

ADVICE: Mapping[str, str] = {
    "torsional_compliance": "move no faster than the resonance allows: shape the reference or put "
    "a notch at it",
    "actuator_saturation": "lower the reference's acceleration until the command stays below the "
    "limit",
    "actuator_rate_limit": "lower the reference's jerk until the command changes more slowly than "
    "the limit",
    "actuator_lag": "tune the gains with the augmented twin, or feed the reference's torque "
    "forward by the lag's time earlier",
    "transport_delay": "tune the gains with the augmented twin, or feed the reference's torque "
    "forward by the delay earlier",
    "thermal_derating": "lower the mean square of the current, or cool the motor",
    "supply_voltage_limit": "lower the top speed, or raise the supply voltage",
    "sensor_eccentricity": "correct the reading where it is taken: calibrate the encoder over a "
    "turn",
    "sensor_lag": "shorten the filter of the encoder; tune the gains with the augmented twin",
    "sensor_offset": "home the axis again",
    "sensor_scale": "correct the scale of the encoder",
    "periodic_disturbance": "its phase is not known at the next start: find and isolate the "
    "source, or add a resonant controller at its frequency",
    "pulse_disturbance": "it passed and will not come again by the clock: find what pushed the "
    "axis",
}
"""Advice for effects that no feed-forward cancels."""
