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
    given = {**twin.parameters, **tables}
    try:
        with FmuTwin(twin.path, parameters=given, driven_ports=twin.driven_ports) as known:
            exported, scalars = _exported(known, recordings, folder, seed)
    except GmfboError:
        # A study must not end because its twin cannot be completed.
        return None
    if not scalars:
        return None
    augmented = FmuTwin(exported, driven_ports=twin.driven_ports)
    effects = dict.fromkeys(one.name.split(".")[1].replace("_", " ") for one in scalars)
    return Completion(augmented, scalars, (), {}, f"estimated together with {', '.join(effects)}")


def _exported(
    twin: FmuTwin, recordings: Sequence[Recording], folder: Path, seed: int
) -> tuple[Path, tuple[Scalar, ...]]:
    """Twin file of the exported twin, and the parameters of its physics; none without a port."""
    from gmfbo.diagnosis.case.open_case import open_case

    case = open_case(twin, recordings, seed=seed, jobs=1)
    case.simulations.close()
    excitation = case.setting.excitation
    # A friction that no reversal tells from a load is estimated all the same.
    moves = bool({"position", "velocity"} & set(twin.file.states))
    laws = [
        law
        for name in USUAL
        if (law := CATALOGUE[name]).port in twin.file.ports
        and law.port in PORT_OUTPUTS
        and (law.region_state != "velocity" or moves)
    ]
    if not laws:
        return folder, ()
    folder.mkdir(parents=True, exist_ok=True)
    settings = dict(case.simulations.settings)
    for law in laws:
        settings |= law.variables({}, excitation)
    exported = export_augmented(
        twin,
        folder,
        parameters={},
        physics=[one for law in laws for one in _switched_off(law)],
        settings=settings,
        substeps=case.substeps,
    )
    scalars = tuple(
        Scalar(f"physics.{law.name}.{one.name}", 0.0, one.low(excitation), one.high(excitation))
        for law in laws
        for one in law.parameters
    )
    return exported.twin_file, scalars


def _switched_off(law: Effect) -> list[PhysicsParameter]:
    return [
        PhysicsParameter(f"{law.name}.{one.name}", 0.0, "", f"{one.words}: {law.equation}")
        for one in law.parameters
    ]
