"""What a twin does between rows, and whether its position contains the sensor port."""

from __future__ import annotations

import numpy as np

from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.twin import FmuTwin

READ_BACK = 0.5  # of the signal added at the sensor port: a reading that contains it shows more
_STEP_CHANGE = 0.01  # of a signal's range: largest RMS change allowed by a finer communication step


def steps_finely(twin: FmuTwin, recording: Recording, substeps: int) -> bool:
    """Whether a twin's outputs stay the same with `substeps` communication steps in place of one.

    Some FMUs refuse finer steps; in others the controller computes once a step of any length.
    """
    responses = []
    for count in (1, substeps):
        with AugmentedTwin(twin, substeps=count) as simulator:
            plan = simulator.plan(recording, {})
            responses.append(simulator.run(plan, {}))
    whole, fine = responses
    if whole.outcome.status != "ok":
        return True  # the failure is reported where the finer run fails as well
    if fine.outcome.status != "ok":
        return False
    return all(
        float(np.sqrt(np.mean((fine.held[name] - column) ** 2)))
        <= _STEP_CHANGE * max(float(np.ptp(column)), 1e-300)
        for name, column in whole.held.items()
    )


def inputs_unstated(twin: FmuTwin) -> frozenset[str]:
    """Inputs of which the twin file does not say what they do between their rows."""
    return frozenset(
        name
        for name, entry in twin.file.inputs.items()
        if "interpolation" not in entry.model_fields_set
    )


def reads_back(twin: FmuTwin, recording: Recording, substeps: int) -> bool:
    """Whether the state `position` at once contains the signal added at the sensor port.

    Parameters
    ----------
    twin : FmuTwin
        The user's.
    recording : Recording
        Recording that is simulated.
    substeps : int
        Steps of physics within one of the twin.
    """
    with AugmentedTwin(twin, substeps=substeps) as simulator:
        if "sensor" not in simulator.ports or "position" not in twin.file.states:
            return False
        plan = simulator.plan(recording, {})
        plain = simulator.run(plan, {})
        position = plain.states["position"]
        if plain.outcome.status != "ok" or position.size < 2:
            return False
        size = max(1e-3 * float(np.ptp(position)), 1e-6)
        added = simulator.run(plan, {}, excitation={"sensor": np.full(position.size, size)})
        moved = float(added.states["position"][1] - position[1])
    return bool(moved > READ_BACK * size)
