"""Statements that are the same: a parameter that the twin has, and the law that changes it."""

from __future__ import annotations

EQUIVALENTS = {
    "inertia": "load_inertia",
    "mass": "load_inertia",
    "viscous": "viscous_friction",
    "viscous_friction": "viscous_friction",
    "torque_constant": "actuator_gain_loss",
    "force_gain": "actuator_gain_loss",
    "torque_gain": "actuator_gain_loss",
    "torque_lag": "actuator_lag",
    "torque_limit": "actuator_saturation",
    "voltage_limit": "actuator_saturation",
    "u_max": "actuator_saturation",
    "u_min": "actuator_saturation",
    "drag": "quadratic_drag",
    "arm": "gravity_torque",
    "arm_phase": "gravity_torque",
    "spring": "elastic_return",
    "spring_rest": "elastic_return",
    "push": "constant_torque_offset",
    "ripple": "cogging_torque",
    "ripple_phase": "cogging_torque",
}
"""Last part of an FMU parameter's name = effect of the library that changes the same."""

PARAMETER = "parameter:"
"""What stands before a parameter's name in a set (contract, schema 2)."""


def same_statement(name: str) -> str:
    """The effect that a name stands for, or the name itself.

    Parameters
    ----------
    name : str
        An effect, or `parameter:NAME`.
    """
    if not name.startswith(PARAMETER):
        return name
    own = name.removeprefix(PARAMETER)
    return EQUIVALENTS.get(own.rsplit(".", 1)[-1], name)


def statements_of_parameter(name: str) -> frozenset[str]:
    """All that says "this parameter is not what the twin holds".

    Parameters
    ----------
    name : str
        FMU name of the parameter.
    """
    own = PARAMETER + name
    return frozenset({own, same_statement(own)})
