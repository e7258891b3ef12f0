"""What a recorded position holds of what acts at the sensor port."""

from __future__ import annotations

from gmfbo.diagnosis.runs.logging_convention import shows_late
from gmfbo.diagnosis.runs.simulated import Reading
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.signal_parts import Rig
from gmfbo.sources.twin.twin import FmuTwin


def recorded_reading(
    twin: FmuTwin, simulations: Simulations, rig: Rig, substeps: int
) -> Reading | None:
    """The recorded position, where its column lacks the sensor port's signal, or is late.

    Parameters
    ----------
    twin : FmuTwin
        The user's.
    simulations : Simulations
        Of the recordings.
    rig : Rig
        Where the position is.
    substeps : int
        Steps of physics in a communication step.
    """
    file, port = twin.file, twin.file.ports.get("sensor")
    if rig.position is None or port is None:
        return None
    if port in file.wires and file.wires[port] == file.outputs[rig.position].variable:
        return Reading(rig.position, rig.position_to_si)
    if not shows_late(simulations, rig.position, rig.position_to_si):
        return None
    return Reading(rig.position, rig.position_to_si, 1.0 / substeps)
