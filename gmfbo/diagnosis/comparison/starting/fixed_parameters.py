"""Parameters that a twin file holds fixed, and that hypotheses may free."""

from __future__ import annotations

import re
from collections.abc import Collection

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.sources.binding.name_patterns import matching
from gmfbo.sources.fmu_file.job import ValueType
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.uncertain import Uncertain

_RANGE = 4.0
"""Times the value of a freed parameter, either way: three standard deviations and a half."""

_MOST = 20
_SMALL_CHANGE = 1.05  # times the value of a parameter, that any model of an axis stands

_NO_PHYSICS = frozenset({"initial", "init", "start", "seed", "step", "sample", "period"})
"""Words of a name that belong to the simulation, or to one run, and not to the axis."""


def fixed_parameters(case: Case, held: Collection[str]) -> list[Uncertain]:
    """Real parameters that are held fixed and that a small factor may change.

    Of more than twenty, those whose change by a twentieth moves the signals most.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    held : collection of str
        FMU parameters that nobody may doubt, beside those under `[fixed]`.
    """
    found = changeable(case.twin, held)
    return found if len(found) <= _MOST else _largest(case, found)


def changeable(
    twin: FmuTwin, held: Collection[str], *, also_certain: bool = False
) -> list[Uncertain]:
    """Real parameters that are not zero and that nothing names, about the value that runs.

    Many vendors declare every parameter `fixed`, which means during a run. So it tells nothing of
    the axis, and both kinds compete.

    Parameters
    ----------
    twin : FmuTwin
        With its twin file.
    held : collection of str
        As of `fixed_parameters`.
    also_certain : bool
        With those under `[fixed]`.
    """
    file, binding = twin.file, twin.binding
    patterns = () if also_certain else file.fixed.names
    certain = [n for p in patterns for n in matching(p, binding.parameters)]
    stated = {*file.uncertain, *file.initial, *file.gains, *certain, *held}
    found = []
    for name, bound in binding.parameters.items():
        variable = bound.variable
        if name in stated or "[" in name or _NO_PHYSICS & set(_words(name)):
            continue
        if variable.value_type not in (ValueType.REAL, ValueType.FLOAT32):
            continue
        value = twin.nominal(name)  # as the twin runs, not its FMU
        low, high = sorted((value / _RANGE, value * _RANGE))
        low = max(low, variable.minimum if variable.minimum is not None else low)
        high = min(high, variable.maximum if variable.maximum is not None else high)
        if low < value < high:
            found.append(Uncertain(name, value, low, high))
    return found


def slightly_changed(one: Uncertain) -> float:
    """[FMU's unit] A twentieth more than a parameter's value, or less where its FMU has no room."""
    more = one.nominal * _SMALL_CHANGE
    return more if one.low <= more <= one.high else one.nominal / _SMALL_CHANGE


def _words(name: str) -> list[str]:
    """Words of a name in lower case: sample_time, sampleTime and ctl.sample.time are alike."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", name)
    return re.findall(r"[a-z]+", apart.lower())


def _largest(case: Case, found: list[Uncertain]) -> list[Uncertain]:
    simulations = case.simulations
    points = [Point({one.name: slightly_changed(one)}) for one in found]
    sizes = [_change(case, runs) for runs in simulations.run(points)]
    order = np.argsort(sizes)[::-1][:_MOST]
    return [found[i] for i in sorted(order) if sizes[i] > 0.0]


def _change(case: Case, runs: list[Simulated]) -> float:
    """Mean square change from the nominal twin, by the range of each signal; 0 if a run ended."""
    if not all(run.finite for run in runs):
        return 0.0
    total = 0.0
    for record, run, nominal in zip(case.simulations.records, runs, case.nominal, strict=True):
        for signal, after, before in zip(record.signals, run.signals, nominal.signals, strict=True):
            extent = float(np.ptp(signal.values))
            if extent > 0.0:
                total += float(np.mean((after - before) ** 2)) / extent**2
    return total
