"""The new nulls: each has nothing to name, and something that has been taken for physics."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from tests.blind.draft import Draft, draft_of
from tests.blind.draw.certificate import certify
from tests.blind.draw.mujoco_axis import INTEGRATORS
from tests.blind.draw.rich import rich_machine
from tests.blind.draw.rigs import Rig
from tests.blind.experiments import experiments_of
from tests.blind.hidden import Rng
from tests.blind.machines import MACHINES, Machine
from tests.blind.oracle import Experiment
from tests.blind.plan import Plan
from tests.blind.truth import SAMPLE

CLOSED = ("servo", "wires_pid", "axis", "servo_torque", "wires_cascade_p_pi", "wires_pd_filtered")
SERVOS = ("servo", "servo_torque", "servo_measured")


@dataclass
class NullCase:
    """A null before it is recorded.

    Attributes
    ----------
    machine : Machine
        With the twin's parameters as the case has them.
    draft : Draft
        True and believed values, logger.
    experiments : list of Experiment
        What is asked of it.
    rig : Rig
        How it is played and logged.
    told : dict
        For the answer: a certificate, a fixed parameter.
    models : Path
        Folder for FMUs that the draw builds.
    """

    machine: Machine
    draft: Draft
    experiments: list[Experiment]
    rig: Rig
    models: Path
    told: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Variant:
    """One kind of a kind of null.

    Attributes
    ----------
    machines : tuple of str
        On which it is drawn, in turn.
    change : callable
        Puts it into a case.
    details : tuple of str
        Of its plan: `exact` where inertia and viscous friction are as the twin says.
    parameter : str
        Truth parameter that a fixed one is wrong of.
    """

    machines: tuple[str, ...]
    change: Callable[[NullCase, Rng, Variant], None]
    details: tuple[str, ...] = ()
    parameter: str = ""


def draft_null(variant: Variant, machine: str, models: Path, rng: Rng) -> NullCase:
    """Draw a null of a variant on a machine.

    Parameters
    ----------
    variant : Variant
        Of `VARIANTS`.
    machine : str
        One of its machines; `rich` is the one with fifteen uncertain parameters.
    models : Path
        Folder for FMUs that the draw builds.
    rng : Generator
        Decides on all the rest.
    """
    chosen = rich_machine(models) if machine == "rich" else MACHINES[machine]
    draft = draft_of(Plan("null", chosen.name, details=variant.details), chosen, rng)
    case = NullCase(chosen, draft, experiments_of(chosen, draft.true, rng), Rig(), models)
    variant.change(case, rng, variant)
    return case


def _log_uniform(rng: Rng, low: float, high: float) -> float:
    return float(low * (high / low) ** rng.random())


def _noisy_logger(case: NullCase, rng: Rng, variant: Variant) -> None:
    """As much as the encoder's own noise, up to ten times that; half of the loops are clean."""
    size = case.machine.jitter * _log_uniform(rng, 1.0, 10.0)
    case.rig = case.rig.changed(position_noise=size, loop_is_clean=bool(rng.random() < 0.5))


def _coarse_logger(case: NullCase, rng: Rng, variant: Variant) -> None:
    """Counts of 4 to 16 of the encoder's, and 10 to 14 bits over the command's range."""
    count = case.machine.quantum * float(rng.choice([4.0, 8.0, 16.0]))
    bits = 2.0 * case.draft.true["u_limit"] / 2.0 ** float(rng.choice([10, 12, 14]))
    case.rig = case.rig.changed(
        position_count=count,
        command_count=bits if not case.machine.is_open_loop else 0.0,
        loop_is_clean=bool(rng.random() < 0.5),
    )


def _jittering_position(case: NullCase, rng: Rng, variant: Variant) -> None:
    """Of 0.1 to 0.4 ms either way; the command's column keeps its time."""
    case.rig = case.rig.changed(jitter=float(rng.uniform(1e-4, 4e-4)))


def _jittering_rows(case: NullCase, rng: Rng, variant: Variant) -> None:
    """Of both columns: the command is the old or the new one, so that neither word is true."""
    case.rig = case.rig.changed(jitter=float(rng.uniform(1e-4, 4e-4)), jitters_command=True)
    case.draft.logged = ""


def _low_pass(column: str) -> Callable[[NullCase, Rng, Variant], None]:
    """A logged column behind a filter of 0.5 to 3 samples."""

    def change(case: NullCase, rng: Rng, variant: Variant) -> None:
        time = _log_uniform(rng, 0.5 * SAMPLE, 3.0 * SAMPLE)
        case.rig = case.rig.changed(low_pass=time, filtered=column)

    return change


def _many(case: NullCase, rng: Rng, variant: Variant) -> None:
    """Each of the fifteen is up to 15 % off, but the limit, which nothing reaches."""
    for own in case.machine.uncertain:
        if own not in ("inertia", "viscous", "u_limit"):
            case.draft.true[own] *= rng.uniform(0.85, 1.15)
    case.told["uncertain"] = len(case.machine.uncertain)


def _unidentifiable(case: NullCase, rng: Rng, variant: Variant) -> None:
    """The torque per unit of command is uncertain beside inertia and friction: only ratios show."""
    name = case.machine.fixed["torque_gain"]
    fixed = {own: fmu for own, fmu in case.machine.fixed.items() if own != "torque_gain"}
    uncertain = {**case.machine.uncertain, "torque_gain": name}
    case.machine = replace(case.machine, uncertain=uncertain, fixed=fixed)
    case.draft.true["torque_gain"] *= rng.uniform(0.85, 1.15)
    case.told["uncertain"] = len(case.machine.uncertain)


def _wrong_fixed(case: NullCase, rng: Rng, variant: Variant) -> None:
    """The truth is 1.3 to 2 times what the twin holds fixed, or the other way round.

    A gain beside uncertain inertia and friction is at most 1.6 times: it moves them as much, and
    their ranges reach to twice.
    """
    own = variant.parameter
    is_absorbed = own == "torque_gain" and not case.machine.is_measured
    factor = float(rng.uniform(1.3, 1.6 if is_absorbed else 2.0))
    believed = case.draft.believed[own]
    true = believed * factor if rng.random() < 0.7 else believed / factor
    case.draft.true[own] = true
    names = {**case.machine.uncertain, **case.machine.fixed}
    name = names.get(own, f"controller.{own}")
    case.told["fixed"] = {"name": name, "true": true, "believed": believed}


def _torque_noise(case: NullCase, rng: Rng, variant: Variant) -> None:
    """0.1 N m where the motor has 10 N m, as its share elsewhere; slower than 3 to 30 Hz."""
    true = case.draft.true
    level = 0.01 * true["u_limit"] * true["torque_gain"]
    case.rig = case.rig.changed(load=level, load_corner=_log_uniform(rng, 3.0, 30.0))


def _fast(averages: bool) -> Callable[[NullCase, Rng, Variant], None]:
    """Four samples of the controller in a row; the twin knows it, and its encoder is any."""

    def change(case: NullCase, rng: Rng, variant: Variant) -> None:
        counts = float(rng.choice([4096.0, 16384.0, 65536.0]))
        fixed = {**case.machine.fixed, "sample": "sample_time"}
        quantum = 6.283185307179586 / counts
        case.machine = replace(case.machine, fixed=fixed, quantum=quantum)
        case.draft.believed["sample"] = SAMPLE / 4.0
        case.rig = case.rig.changed(rate=4, averages=averages)
        case.told["counts"] = counts

    return change


def _in_mujoco(case: NullCase, rng: Rng, variant: Variant) -> None:
    """Certified on the references of the case."""
    integrator = str(rng.choice(list(INTEGRATORS)))
    shown = certify(case.machine, case.draft.true, case.experiments, integrator)
    case.rig = case.rig.changed(mujoco_step=shown.step, mujoco_integrator=integrator)
    case.told["certificate"] = shown.told()


def _fixed(parameter: str, *machines: str, details: tuple[str, ...] = ()) -> Variant:
    return Variant(machines, _wrong_fixed, details, parameter)


VARIANTS: Mapping[str, Mapping[str, Variant]] = {
    "old": {},
    "logger": {
        "noise": Variant((*CLOSED, "bench"), _noisy_logger),
        "counts": Variant((*CLOSED, "bench"), _coarse_logger),
    },
    "timing": {
        "jitter_of_position": Variant((*CLOSED, "bench"), _jittering_position),
        "low_pass_of_command": Variant(CLOSED, _low_pass("command")),
        "jitter_of_rows": Variant(CLOSED, _jittering_rows),
        "low_pass_of_position": Variant(CLOSED, _low_pass("position")),
    },
    "parameters": {
        "many": Variant(("rich",), _many),
        "unidentifiable": Variant(
            ("wires_pid", "axis", "bench", "wires_cascade_p_pi", "wires_pd_filtered"),
            _unidentifiable,
        ),
    },
    "fixed": {
        "filter_time": _fixed(
            "filter_time", "servo", "wires_pid", "servo_torque", "wires_measured"
        ),
        "torque_lag": _fixed("torque_lag", "servo", "servo_measured", "servo_torque"),
        "inertia": _fixed("inertia", "servo_measured", "axis_measured", "wires_measured"),
        "gain": _fixed(
            *("torque_gain", "axis_measured", "wires_pid", "axis", "wires_measured"),
            details=("exact",),
        ),
        "viscous": _fixed("viscous", "axis_measured", "servo_measured", "wires_measured"),
        "cascade_filter": _fixed("filter_time", "wires_cascade_p_pi", "wires_pd_filtered"),
    },
    "loop": {
        "torque_noise": Variant(CLOSED, _torque_noise),
        "fast_decimated": Variant(SERVOS, _fast(averages=False)),
        "fast_averaged": Variant(SERVOS, _fast(averages=True)),
    },
    "simulator": {"mujoco": Variant(("servo", "servo_torque", "servo_measured"), _in_mujoco)},
}
"""By kind of null and name; `old` ones are plans of the blind benchmark."""
