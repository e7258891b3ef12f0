"""Units of metrics, from the units of the signals that they are computed of."""

from __future__ import annotations

from collections.abc import Mapping

from gmfbo.objective.metrics import METRICS
from gmfbo.objective.tracking import COMMAND_METRICS, TRACKING_METRICS

_STEP_UNITS = {name: "%" if name == "overshoot" else "s" for name in METRICS}

# Work of a torque along an angle, and of a force along a way.
_JOULE = {("N.m", "rad"), ("N", "m")}


def units_of_metrics(signal_unit: str, command_unit: str) -> dict[str, str]:
    """Unit of each metric of ours.

    Parameters
    ----------
    signal_unit : str
        SI unit of the scored signal; empty where unknown.
    command_unit : str
        SI unit of the command; empty where unknown.

    Returns
    -------
    dict of str to str
        Empty texts where a unit is unknown.
    """
    itae, rms_error = TRACKING_METRICS
    way = signal_unit.removesuffix("/s")
    product = f"{command_unit}.{way}" if command_unit and way else ""
    return {
        **_STEP_UNITS,
        itae: f"{signal_unit}.s2" if signal_unit else "",
        rms_error: signal_unit,
        **dict.fromkeys(COMMAND_METRICS, command_unit),
        "energy": "J" if (command_unit, way) in _JOULE else product,
    }


def metric_unit(name: str, units: Mapping[str, str] | None = None) -> str:
    """Unit of a metric; none for a user's own without a stated one.

    Parameters
    ----------
    name : str
        As it is stored; `overshoot[2]` is that of the second reference.
    units : mapping of str to str, optional
        As a study has logged or stated them; without it those of step metrics.
    """
    return {**_STEP_UNITS, "phase_margin": "deg", **(units or {})}.get(name.partition("[")[0], "")
