"""Quadratic drag: fans, fluids and windage."""

import numpy as np

from gmfbo.physics.effect import Effect, Values, positive, sentence
from gmfbo.physics.states import Array, Mask, States


def _signal(states: States, parameters: Values) -> Array:
    return -parameters["coefficient"] * states.velocity * np.abs(states.velocity)


def _acts(states: States, parameters: Values) -> Mask:
    speed = np.abs(states.velocity)
    return np.asarray(speed > 0.5 * np.max(speed), dtype=np.bool_)


quadratic_drag = Effect(
    name="quadratic_drag",
    port="torque",
    family="friction",
    signal_path="plant",
    parameters=(
        positive(
            "coefficient", "Drag coefficient", "torque/velocity2", lambda e: e.torque / e.speed**2
        ),
    ),
    starts=lambda e: [{"coefficient": 0.07 * e.torque / e.speed**2}],
    size=lambda p, e: p["coefficient"],
    size_name="coefficient",
    size_unit="torque/velocity2",
    floor=lambda e: 1.5e-4 * e.torque / e.speed**2,
    signal=_signal,
    feature=lambda states: _signal(states, {"coefficient": 1.0}),
    acts=_acts,
    region=lambda p, units: "where the velocity is high",
    region_state="velocity",
    statement=sentence(
        "Drag that grows with the square of the speed, about {coefficient} {place}, is missing "
        "from the twin.",
        coefficient="torque/velocity2",
    ),
    equation="tau = -c * omega * abs(omega)",
    source="Rayleigh, 1876",
    confused_with={
        "viscous_friction": "three constant speeds, the highest as high as is safe",
        "stribeck_friction": "low speeds, where drag vanishes",
        "supply_voltage_limit": "high speed at little torque: drag is there, a limit is not",
    },
)
