"""Rate limit: the actuator follows the command no faster than a slope."""

import numpy as np

from gmfbo.physics.effect import Effect, EffectParameter, Values, sentence
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask, States
from gmfbo.units import quantity

_SHARES = (3.0, 0.9, 0.5, 0.2, 0.05, 0.012)  # of the fastest command
_LEAST_LAG = 0.02  # of a row, behind its largest change


def _followed(states: States, rate: float) -> Array:
    """Output that starts on the command and moves at most `rate` per second, shape (n,)."""
    most = rate * states.step
    result = np.empty_like(states.command)
    output = float(states.command[0])
    for index, command in enumerate(states.command.tolist()):
        output += min(max(command - output, -most), most)
        result[index] = output
    return result


def _signal(states: States, parameters: Values) -> Array:
    return _followed(states, parameters["rate"]) - states.command


def _acts(states: States, parameters: Values) -> Mask:
    behind = np.abs(_signal(states, parameters))
    # A jump of the command is followed within the row, but not at once.
    late = np.abs(np.diff(states.command, prepend=states.command[:1]))
    return np.asarray(
        (behind > 1e-9 * max(np.max(np.abs(states.command)), 1e-300))
        | (late > _LEAST_LAG * parameters["rate"] * states.step)
    )


def _fastest(excitation: Excitation) -> float:
    """Rate at which the largest jump takes so little of a sample that nothing shows it."""
    return excitation.command_rate / _LEAST_LAG


def _starts(excitation: Excitation) -> list[Values]:
    rates = [share * excitation.command_rate for share in _SHARES]
    return [{"rate": rate} for rate in rates if rate < _fastest(excitation)]


actuator_rate_limit = Effect(
    name="actuator_rate_limit",
    port="command",
    family="limit",
    signal_path="actuator",
    parameters=(
        EffectParameter(
            "rate",
            "Largest rate of the command",
            "command/s",
            low=lambda e: 0.003 * e.command_rate,
            high=_fastest,
            scale=lambda e: 0.1 * e.command_rate,
        ),
    ),
    starts=_starts,
    size=lambda p, e: e.sample * e.command_rate / p["rate"],
    size_name="lag",
    size_unit="s",
    floor=lambda e: _LEAST_LAG * e.sample,
    signal=_signal,
    acts=_acts,
    region=lambda p, units: (
        "where the command changes faster than " + quantity(p["rate"], units.resolve("command/s"))
    ),
    region_state="command",
    statement=sentence(
        "The actuator follows at most {rate}, a rate limit that is missing from the twin.",
        rate="command/s",
    ),
    equation="abs(d(u_out)/dt) <= rate",
    source="Rundqwist and Ståhl-Gunnarsson, 1996",
    confused_with={
        "actuator_lag": "small fast commands, which a rate limit passes",
        "actuator_saturation": "slow large commands, which a rate limit passes",
        "transport_delay": "small fast commands, which a rate limit passes",
    },
)
