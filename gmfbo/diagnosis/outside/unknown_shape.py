"""The curve of what is unknown, in the twin's units."""

from __future__ import annotations

from gmfbo.diagnosis.comparison.unknown.beside import Unknown
from gmfbo.diagnosis.result.whereabouts import Shape
from gmfbo.physics import Units


def shape_of(unknown: Unknown, units: Units) -> Shape | None:
    """State the curve of a free function; None where no curve over one state holds most of it.

    Parameters
    ----------
    unknown : Unknown
        As it is believed.
    units : Units
        Of ports and states.
    """
    curve = unknown.function.curve()
    if curve is None:
        return None
    by_port = {"torque": units.torque, "command": units.command, "sensor": units.position}
    by_state = {
        "position": units.position,
        "velocity": units.velocity,
        "command": units.command,
        "time": "s",
    }
    return Shape(
        port=unknown.port,
        against=curve.against,
        x=tuple(curve.x.tolist()),
        y=tuple(curve.y.tolist()),
        y_low=tuple((curve.y - curve.half).tolist()),
        y_high=tuple((curve.y + curve.half).tolist()),
        unit_x=by_state[unknown.against],
        unit_y=by_port[unknown.port],
    )
