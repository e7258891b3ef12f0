"""Signals of an unknown FMU, under the names that people give them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from gmfbo.errors import FmuFileError
from gmfbo.recordings.columns.column_guesses import quantity_of_unit
from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.sources.fmu_file.fmu_variable import FmuVariable
from gmfbo.sources.inspection.fmu_report import FmuReport
from gmfbo.sources.inspection.role_guesses import Guesses, guess_roles, is_reference
from gmfbo.sources.twin_file.toml_lines import bare_key, free_key

_COMMAND = re.compile(r"command|cmd|soll|demand|(^|[._])u$", re.IGNORECASE)
_SENSOR = re.compile(r"sensor|enc|meas|reading|logged", re.IGNORECASE)
_UNSEEN = re.compile(r"true|ideal|ref|set_?point|error|der\(", re.IGNORECASE)
"""Names of what no logger sees, or what is asked for and not done."""


@dataclass(frozen=True)
class Signal:
    """A signal that a log may hold.

    Attributes
    ----------
    name : str
        In the twin file.
    variable : FmuVariable
        Input that it drives, or variable that it is compared with.
    driven : bool
        Whether it drives an input.
    usual : bool
        Whether its name is a usual one: then a column may be guessed by what its name means.
    """

    name: str
    variable: FmuVariable
    driven: bool
    usual: bool

    @property
    def spec(self) -> SignalSpec:
        """For those who look for its column."""
        return SignalSpec(
            self.name,
            self.name,
            unit=self.variable.si_unit,
            driven=self.driven,
            compared=not self.driven,
        )


@dataclass(frozen=True)
class Signals:
    """Signals of an FMU.

    Attributes
    ----------
    report : FmuReport
        What the FMU is.
    guesses : Guesses
        Roles of its variables.
    known : mapping of str to Signal
        By name, the likeliest to be logged first.
    ends_announced : bool
        Whether the FMU refuses a run whose end is not announced.
    """

    report: FmuReport
    guesses: Guesses
    known: Mapping[str, Signal]
    ends_announced: bool = False

    @cached_property
    def by_variable(self) -> Mapping[str, str]:
        """Name of the signal by the FMU's variable."""
        return {signal.variable.name: name for name, signal in self.known.items()}

    @property
    def driven(self) -> list[Signal]:
        """Those that drive inputs."""
        return [signal for signal in self.known.values() if signal.driven]

    @property
    def controlled(self) -> Signal | None:
        """Output in the reference's unit, which has to follow it; None in open loop."""
        reference = self.known.get("reference")
        if reference is None or not reference.driven:
            return None
        unit = reference.variable.si_unit
        alike = (s for s in self.known.values() if not s.driven and s.variable.si_unit == unit)
        return next(alike, None) if unit else None


def signals_of(report: FmuReport) -> Signals:
    """Name the signals of an FMU.

    Parameters
    ----------
    report : FmuReport
        Of `inspect_fmu`.

    Raises
    ------
    FmuFileError
        It cannot run on this machine, or has nothing to compare.
    """
    if report.obstacle:
        raise FmuFileError(report.obstacle)
    guesses = guess_roles(report.inputs, report.outputs, report.parameters, report.local)
    outputs = [v for v in report.outputs if v.value_type is not None]
    outputs += [g.variable for g in guesses.outputs if g.variable not in outputs]
    if not outputs:
        raise FmuFileError(
            f"'{report.path.name}' has no output that is a number: expected one that a recording "
            "holds too; write the twin file by hand, [outputs] also takes local variables"
        )
    taken: set[str] = set()
    found = [*_inputs(guesses.inputs, taken), *_outputs(outputs, taken)]
    return Signals(report, guesses, {signal.name: signal for signal in found})


def _inputs(driven: Sequence[FmuVariable], taken: set[str]) -> Iterator[Signal]:
    # The checks of a closed loop look for a signal called reference.
    asked = next((v for v in driven if is_reference(v)), None)
    if asked is not None:
        yield Signal(free_key("reference", taken), asked, driven=True, usual=True)
    for variable in driven:
        if variable is not asked:
            name = free_key(bare_key(variable.name), taken)
            yield Signal(name, variable, driven=True, usual=True)


def _outputs(outputs: Sequence[FmuVariable], taken: set[str]) -> Iterator[Signal]:
    usual: dict[str, FmuVariable] = {}
    for quantity in ("position", "velocity", "force", "current", "voltage", "temperature"):
        best = _likeliest(quantity, [v for v in outputs if quantity_of_unit(v.si_unit) == quantity])
        if best is not None:
            usual[free_key(_usual_name(quantity, best), taken)] = best
    for name, variable in usual.items():
        yield Signal(name, variable, driven=False, usual=True)
    for variable in outputs:
        if variable not in usual.values():
            name = free_key(bare_key(variable.name), taken)
            yield Signal(name, variable, driven=False, usual=False)


def _likeliest(quantity: str, variables: Sequence[FmuVariable]) -> FmuVariable | None:
    """The variable that a logger most likely holds; None where several are as likely."""
    seen = [v for v in variables if not _UNSEEN.search(v.name)] or [*variables]
    pattern = _COMMAND if quantity in ("force", "current", "voltage") else _SENSOR
    named = [v for v in seen if bare_key(v.name).lower() == quantity]
    fitting = [v for v in seen if pattern.search(v.name)]
    for choice in (named, fitting, seen):
        if len(choice) == 1:
            return choice[0]
    return None


def _usual_name(quantity: str, variable: FmuVariable) -> str:
    if quantity != "force":
        return quantity
    kind = "torque" if variable.si_unit == "N.m" else "force"
    return f"{kind}_command" if _COMMAND.search(variable.name) else kind
