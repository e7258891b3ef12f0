"""Load-dependent friction: gears and screws rub more under load."""

import numpy as np

from gmfbo.physics import friction
from gmfbo.physics.effect import Effect, Values, positive, sentence
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask, States


def _signal(states: States, parameters: Values) -> Array:
    level = parameters["level"] + parameters["coefficient"] * states.load
    return -level * states.direction


def _feature(states: States) -> Array:
    largest = max(float(np.max(states.load)), np.finfo(float).tiny)
    return _signal(states, {"level": 0.5, "coefficient": 0.5 / largest})


def _not_excited(excitation: Excitation) -> str | None:
    if not excitation.is_loaded:
        return "no load: the current stays at zero"
    return friction.no_reversal(excitation)


def _acts(states: States, parameters: Values) -> Mask:
    loaded = states.load > 0.5 * np.max(states.load)
    return states.near_reversals() | (loaded & (np.abs(states.velocity) > states.rest))


load_dependent_friction = Effect(
    name="load_dependent_friction",
    port="torque",
    family="friction",
    signal_path="plant",
    parameters=(
        positive(
            "coefficient", "Friction per load", "torque/load", lambda e: e.torque / e.load_range
        ),
        friction.level("Friction without load"),
    ),
    fixed=friction.fixed_deflection,
    own_nuisances=(friction.own_deflection(),),
    starts=lambda e: [{"level": 0.03 * e.torque, "coefficient": 0.07 * e.torque / e.load_range}],
    size=lambda p, e: p["level"] + p["coefficient"] * e.load_range,
    size_name="level",
    size_unit="torque",
    floor=friction.floor,
    not_excited=_not_excited,
    signal=_signal,
    feature=_feature,
    acts=_acts,
    region=lambda p, units: "where the velocity changes sign and the current is high",
    region_state="velocity",
    statement=sentence(
        "Friction {place} that grows with the load is missing from the twin: about {level} and "
        "{coefficient} times the load on top.",
        level="torque",
        coefficient="torque/load",
    ),
    equation="tau = -(F_c + mu * abs(tau_load)) * sign(omega)",
    source="Hamon, Gautier and Garrec, 2010",
    contains=("coulomb_friction",),
    as_limit={"level": "level"},
    confused_with={
        "coulomb_friction": "two loads at one speed",
        "actuator_gain_loss": "a reversal: friction changes its sign there, a gain does not",
    },
)
