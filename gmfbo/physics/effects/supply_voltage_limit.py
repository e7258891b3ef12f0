"""Supply voltage limit: fast motion leaves less voltage for torque, and more to brake."""

from collections.abc import Iterable, Sequence

import numpy as np

from gmfbo.physics import limits
from gmfbo.physics.effect import Effect, EffectParameter, Values, sentence
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, States

_SLOPES = 30  # of its further starts
_ROUND_OFF = 1e-9  # of the limit


def _change(states: States, parameters: Values) -> Array:
    """By which the limits at both ends change the command, shape (n,)."""
    back = parameters["slope"] * states.velocity
    limited = np.clip(states.command, -parameters["limit"] - back, parameters["limit"] - back)
    return np.asarray(limited - states.command, dtype=np.float64)


def _slope(excitation: Excitation) -> float:
    return excitation.command / excitation.speed


def _met(excitation: Excitation, slopes: Iterable[float], shares: Sequence[float]) -> list[Values]:
    """Limits that fall by these slopes, and that the motion meets seldom to often."""
    return [
        {"limit": share * excitation.largest_demand(slope), "slope": slope}
        for slope in slopes
        for share in shares
    ]


def _starts(excitation: Excitation) -> list[Values]:
    slopes = [share * _slope(excitation) for share in (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)]
    return _met(excitation, slopes, limits.SHARES)


def _more_starts(excitation: Excitation) -> list[Values]:
    """Each slope meets the motion at another instant."""
    slopes = map(float, _slope(excitation) * np.geomspace(0.05, 1.6, _SLOPES))
    return _met(excitation, slopes, limits.MORE_SHARES)


def _cut(parameters: Values, excitation: Excitation) -> float:
    left = max(0.0, parameters["limit"] - parameters["slope"] * excitation.speed)
    return max(0.0, excitation.command - left)


supply_voltage_limit = Effect(
    name="supply_voltage_limit",
    port="command",
    family="limit",
    signal_path="actuator",
    parameters=(
        EffectParameter(
            "limit",
            "Limit at standstill",
            "command",
            low=lambda e: 0.05 * e.command,
            high=lambda e: 5.0 * e.command,
            scale=lambda e: 0.2 * e.command,
        ),
        # Without a slope it would be a saturation, which has a name of its own.
        EffectParameter(
            "slope",
            "Loss per speed",
            "command/velocity",
            low=lambda e: 0.005 * _slope(e),
            high=lambda e: 5.0 * _slope(e),
            scale=lambda e: 0.1 * _slope(e),
        ),
    ),
    starts=_starts,
    more_starts=_more_starts,
    gone=lambda p, e: {"limit": e.largest_demand(p["slope"])},
    size=_cut,
    size_name="cut",
    size_unit="command",
    floor=limits.cut_floor,
    signal=_change,
    acts=lambda states, p: np.abs(_change(states, p)) > _ROUND_OFF * p["limit"],
    region=lambda p, units: "where command and velocity are high and of one sign",
    region_state="command",
    statement=sentence(
        "A supply limit of about {limit}, less {slope} times the speed, is missing from the twin.",
        limit="command",
        slope="command/velocity",
    ),
    equation="-u_max - k * omega <= u_out <= u_max - k * omega",
    source="Leonhard, 1985",
    contains=("actuator_saturation",),
    confused_with={
        "actuator_saturation": "peaks at low and at high speed: a supply limit falls with speed",
        "viscous_friction": "high speed at little torque: friction is there, a limit is not",
        "quadratic_drag": "high speed at little torque: drag is there, a limit is not",
    },
)
