"""Complete a twin by the physics that nearly every axis has and its twin states wrongly.

Friction, a constant load, a delay and a lag are added to the twin whether or not a diagnosis would
name them, and are estimated with its uncertain parameters. Their prior has its mode at zero, so
that what the real runs do not ask for stays near zero. It takes a few simulations where a diagnosis
takes thousands, and says nothing about causes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from gmfbo.errors import GmfboError
from gmfbo.physics import CATALOGUE, Effect
from gmfbo.recordings.recording import Recording
from gmfbo.retuning.missing_physics import Completion
from gmfbo.retuning.unknowns import Scalar
from gmfbo.sources.binding.augmented_binding import PORT_OUTPUTS
from gmfbo.sources.export.export import PhysicsParameter, export_augmented
from gmfbo.sources.twin.twin import FmuTwin

USUAL = ("coulomb_friction", "constant_torque_offset", "transport_delay", "actuator_lag")
"""Effects that are added: also what a model of low order has beside an inertia and a damping."""


def with_usual_physics(
    twin: FmuTwin,
    tables: Mapping[str, float],
    recordings: Sequence[Recording],
    folder: Path,
    *,
    seed: int,
) -> Completion | None:
    """Export a twin with the usual physics at its ports, all of it switched off.

    Parameters
    ----------
    twin : FmuTwin
        As given.
    tables : mapping of str to float
        Parameters [FMU's unit] of its tables, as estimated.
    recordings : sequence of Recording
        Real runs, which give the ranges.
    folder : Path
        For the augmented FMU; made if it is needed.
    seed : int
        Of the noise runs.

    Returns
    -------
    Completion or None
        None where no port serves an effect, or where this twin cannot be exported.
    """
    from gmfbo.diagnosis.case.open_case import open_case

    given = {**twin.parameters, **tables}
    try:
        with FmuTwin(twin.path, parameters=given, driven_ports=twin.driven_ports) as known:
            case = open_case(known, recordings, seed=seed, jobs=1)
            try:
                excitation = case.setting.excitation
                # A friction that no reversal tells from a load is estimated all the same.
                moves = bool({"position", "velocity"} & set(known.file.states))
                laws = [
                    law
                    for name in USUAL
                    if (law := CATALOGUE[name]).port in known.file.ports
                    and law.port in PORT_OUTPUTS
                    and (law.region_state != "velocity" or moves)
                ]
                if not laws:
                    return None
                folder.mkdir(parents=True, exist_ok=True)
                settings = dict(case.simulations.settings)
                for law in laws:
                    settings |= law.variables({}, excitation)
                exported = export_augmented(
                    known,
                    folder,
                    parameters={},
                    physics=[one for law in laws for one in _switched_off(law)],
                    settings=settings,
                    substeps=case.substeps,
                )
            finally:
                case.simulations.close()
    except GmfboError:
        # A study must not end because its twin cannot be completed.
        return None
    scalars = [
        Scalar(f"physics.{law.name}.{name}", 0.0, low, high)
        for law in laws
        for name, (low, high) in law.bounds(excitation).items()
        if name in {one.name for one in law.parameters}
    ]
    augmented = FmuTwin(exported.twin_file, driven_ports=twin.driven_ports)
    told = ", ".join(law.name.replace("_", " ") for law in laws)
    return Completion(augmented, tuple(scalars), (), {}, f"estimated together with {told}")


def _switched_off(law: Effect) -> list[PhysicsParameter]:
    return [
        PhysicsParameter(f"{law.name}.{one.name}", 0.0, "", f"{one.words}: {law.equation}")
        for one in law.parameters
    ]
