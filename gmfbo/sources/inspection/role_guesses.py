"""Guess the roles of an unknown FMU's variables by names, units, causality, descriptions.

An engineer has to check each guess. Units count most, since a name may be anything, and
descriptions of Modelica's own library say more than its names.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from gmfbo.sources.fmu_file.fmu_variable import FmuVariable
from gmfbo.units import Dimension, parse_unit

_FORCE = ("N", "N.m")
_WAY = ("m", "rad")
_SPEED = ("m/s", "rad/s")
_INERTIA = ("kg", "kg.m2")
_VISCOUS = ("N.s/m", "N.m.s/rad")

_ADDED = re.compile(r"\b(port|dist\w*|noise|offset|fault|extern\w*|added)\b", re.IGNORECASE)
_REFERENCE = re.compile(
    r"(^|\b|_)(ref\w*|set_?point|set(\b|_)|soll|target|desired|goal)"
    r"|(?-i:(?<=[a-z0-9])(Ref|Set|Soll|Target)(?![a-z]))",  # phiRef, posSet
    re.IGNORECASE,
)
_COMMAND = re.compile(r"command|cmd|voltage|duty|current|amplifier", re.IGNORECASE)
_SENSOR = re.compile(r"sensor|enc|measur|reading", re.IGNORECASE)
_LOAD = re.compile(r"\bload\b|\bload[._ ](torque|force)\b", re.IGNORECASE)
_GAIN = re.compile(r"(^|[._\[])[kK]([pPvViIdD]|_[pPvViIdD])?(\d*|[._\[].*)$|gain", re.IGNORECASE)
_NO_GAIN = re.compile(
    r"forward|windup|weight|force|torque|motor|sensor|friction|scale|spring", re.IGNORECASE
)
_STATES = {
    "position": (_WAY, r"pos\w*|angle|phi|theta|(^|[._])(q|s|x)\d*$"),
    "velocity": (_SPEED, r"vel\w*|speed|omega|(^|[._])(v|w|dq)\d*$"),
    "command": (("N", "N.m", "V", "A", "1"), r"command|cmd|voltage|(^|[._])u$"),
    "current": (("A",), r"motor_current|current|(^|[._])i_?q?$"),
    "load_torque": (_FORCE, r"load_torque|load_force|tau_?load"),
    "load_position": (_WAY, r"load_(pos|angle|phi)"),
    "temperature": (("K",), r"temp"),
}
_PREFERRED = re.compile(r"true|rod_|motor_current|mass|inertia|load", re.IGNORECASE)
_AVOIDED = re.compile(
    r"motor_(pos|vel|ang)|logged|ref|sensor|flange|support|housing|der\(|nominal|_rel|initial|fixed",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Guess:
    """A variable and its likely role.

    Attributes
    ----------
    key : str
        Signal, port, state or role.
    variable : FmuVariable
        The variable.
    why : str
        Reason for the guess.
    """

    key: str
    variable: FmuVariable
    why: str


@dataclass(frozen=True)
class Guesses:
    """Guessed entries of a twin file.

    Attributes
    ----------
    inputs, idle : list of FmuVariable
        Inputs that a recording drives, and inputs that keep their start value.
    drive : FmuVariable or None
        Force, current or voltage that drives a plant without a controller.
    outputs : list of Guess
        Local variables that are more informative than the outputs.
    ports, states, roles : list of Guess
        At most one for each key.
    gains, uncertain : list of FmuVariable
        Parameters.
    """

    inputs: list[FmuVariable] = field(default_factory=list)
    idle: list[FmuVariable] = field(default_factory=list)
    drive: FmuVariable | None = None
    outputs: list[Guess] = field(default_factory=list)
    ports: list[Guess] = field(default_factory=list)
    states: list[Guess] = field(default_factory=list)
    roles: list[Guess] = field(default_factory=list)
    gains: list[FmuVariable] = field(default_factory=list)
    uncertain: list[FmuVariable] = field(default_factory=list)


def guess_roles(
    inputs: Sequence[FmuVariable],
    outputs: Sequence[FmuVariable],
    parameters: Sequence[FmuVariable],
    local: Sequence[FmuVariable] = (),
) -> Guesses:
    """Guess the roles of an FMU's variables."""
    numbers = [v for v in inputs if v.value_type is not None]
    ports = list(_ports(numbers))
    taken = {guess.variable.name for guess in ports}
    driven, idle = _driven([v for v in numbers if v.name not in taken])
    drive = _drive(driven)
    if drive is not None:
        key = "torque" if _has_unit(drive, _FORCE) else "command"
        if key not in [guess.key for guess in ports]:
            ports.append(Guess(key, drive, f"it drives the plant{_unit_words(drive)}"))
    states = list(_states(outputs, local, driven))
    # A local variable with a clear name or unit is better than an unclear output.
    shown = [guess for guess in states if guess.variable not in outputs]
    numeric = [v for v in parameters if v.value_type is not None]
    return Guesses(
        inputs=driven,
        idle=idle,
        drive=drive,
        outputs=[guess for guess in shown if guess.key in ("position", "velocity")],
        ports=ports,
        states=states,
        roles=list(_inertia(numeric, states)),
        gains=[v for v in numeric if _is_gain(v)],
        uncertain=[
            v
            for v in numeric
            if v.start and _has_unit(v, (*_INERTIA, *_VISCOUS)) and not _is_gain(v)
        ],
    )


def _ports(inputs: Iterable[FmuVariable]) -> Iterable[Guess]:
    """Inputs that add to a signal, and are zero unless driven."""
    found: dict[str, Guess] = {}
    for variable in inputs:
        name = re.sub(r"[._]", " ", variable.name)
        loads = _LOAD.search(name) and _has_unit(variable, _FORCE)
        if variable.start or not (loads or _ADDED.search(f"{name} {variable.description}")):
            continue
        key = _port_of(variable)
        if key and key not in found:
            why = "its name or description says that it adds"
            found[key] = Guess(key, variable, f"{why}{_unit_words(variable)}")
    return found.values()


def _port_of(variable: FmuVariable) -> str:
    if _COMMAND.search(variable.name) or re.search(r"command", variable.description, re.I):
        return "command"
    if _has_unit(variable, _WAY) or _SENSOR.search(variable.name):
        return "sensor"
    return "torque" if _has_unit(variable, _FORCE) else ""


def _driven(inputs: Sequence[FmuVariable]) -> tuple[list[FmuVariable], list[FmuVariable]]:
    """Inputs that a recording drives, and inputs left at their start value."""
    references = [v for v in inputs if is_reference(v)]
    # Inputs of velocity and torque are feed-forwards, which are zero in many recordings.
    positions = [v for v in references if _has_unit(v, _WAY)]
    # Exporters offer constants as inputs: a spring rate that begins at 1 is no signal.
    driven = positions[:1] or references or [v for v in inputs if not v.start]
    return driven, [v for v in inputs if v not in driven]


def _drive(driven: Sequence[FmuVariable]) -> FmuVariable | None:
    """Input that drives a plant without a controller."""
    if any(is_reference(v) for v in driven):
        return None
    return next((v for v in driven if _has_unit(v, (*_FORCE, "A", "V"))), None)


def _states(
    outputs: Sequence[FmuVariable],
    local: Sequence[FmuVariable],
    driven: Sequence[FmuVariable],
) -> Iterable[Guess]:
    found: dict[str, FmuVariable] = {}
    for key, (units, pattern) in _STATES.items():
        said = [v for v in local if v.unit]  # among thousands of variables a name alone says little
        for group, where in ((outputs, ""), (said, "a local variable, ")):
            best = max(group, key=lambda v: _score(v, units, pattern), default=None)
            if best is None or _score(best, units, pattern) < 2 or best in found.values():
                continue
            found[key] = best
            yield Guess(key, best, f"{where}its name{_unit_words(best)}")
            break
    if "command" not in found and "current" not in found:
        forces = [v for v in outputs if _has_unit(v, _FORCE) and v not in found.values()]
        if forces and not any(is_reference(v) for v in driven):
            yield Guess("command", forces[0], f"the only force{_unit_words(forces[0])}")


def _score(variable: FmuVariable, units: Sequence[str], pattern: str) -> int:
    """Score of a variable: two where it is possible, more where it is likely."""
    if variable.value_type is None or not re.search(pattern, variable.name, re.IGNORECASE):
        return 0
    if variable.unit and not _has_unit(variable, units):
        return 0
    likely = 2 * bool(variable.unit) + bool(_PREFERRED.search(variable.name))
    return 2 + likely - 3 * bool(_AVOIDED.search(variable.name))


def _inertia(parameters: Sequence[FmuVariable], states: Sequence[Guess]) -> Iterable[Guess]:
    """Mass or inertia that fits the position's unit; a load's is preferred to a motor's."""
    way = next((g.variable for g in states if g.key in ("position", "velocity")), None)
    linear = way is not None and _has_unit(way, ("m", "m/s"))
    fitting = [v for v in parameters if v.start and _has_unit(v, ("kg" if linear else "kg.m2",))]
    fitting.sort(key=lambda v: not re.search("load", v.name, re.IGNORECASE))
    if fitting:
        yield Guess("inertia", fitting[0], f"the unit {fitting[0].unit}")


def is_reference(variable: FmuVariable) -> bool:
    """Whether a variable's name is that of a set point."""
    return _REFERENCE.search(variable.name) is not None


def _is_gain(variable: FmuVariable) -> bool:
    return bool(
        variable.start and _GAIN.search(variable.name) and not _NO_GAIN.search(variable.name)
    )


def _has_unit(variable: FmuVariable, units: Iterable[str]) -> bool:
    found = parse_unit(variable.si_unit) if variable.unit else None
    return found is not None and found.dimension in [_DIMENSIONS[u] for u in units if u]


def _unit_words(variable: FmuVariable) -> str:
    return f", unit {variable.unit}" if variable.unit else ", without a unit"


def _dimensions(units: Iterable[str]) -> Mapping[str, Dimension]:
    known = {unit: parse_unit(unit) for unit in units}
    return {unit: found.dimension for unit, found in known.items() if found is not None}


_DIMENSIONS = _dimensions((*_FORCE, *_WAY, *_SPEED, *_INERTIA, *_VISCOUS, "A", "V", "K", "1"))
