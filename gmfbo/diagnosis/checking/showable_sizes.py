"""Smallest size of each effect that recordings could show, alone and all together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.checking.result import Showable
from gmfbo.diagnosis.comparison.numbers import TOLD_APART, UNLIKE
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.decision_told import units_of
from gmfbo.diagnosis.result.named_effect import DetectableSize, NotTestable
from gmfbo.diagnosis.screening.probes import Probe, Screened, probes, screened
from gmfbo.diagnosis.screening.testable_effects import candidates, untestable
from gmfbo.physics import CATALOGUE

_CHUNK = 6  # starts simulated between two reports of progress


@dataclass(frozen=True)
class Excited:
    """Effects that recordings can show, and those that they cannot.

    Attributes
    ----------
    showable : mapping of str to Showable
        Smallest sizes by effect.
    not_testable : tuple of NotTestable
        The other effects, each with its reason.
    """

    showable: Mapping[str, Showable]
    not_testable: tuple[NotTestable, ...]


def showable_sizes(case: Case, progress: Callable[[float], None]) -> Excited:
    """Simulate every effect at its probing size, and scale it to the size that would be named.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    progress : callable (float)
        Called with the share done.
    """
    reasons = untestable(
        case.twin.file,
        case.setting.excitation,
        has_inertia=case.setting.inertia is not None,
        is_open=case.simulations.tracking is not None,
    )
    library = candidates(
        [name for name in CATALOGUE if name not in reasons], case.setting.excitation
    )
    tried = _probed(case, library, progress)
    together, alike = _sizes(case, tried, None)
    reasons |= alike
    alone = {
        record.name: _sizes(case, tried, k)[0] for k, record in enumerate(case.simulations.records)
    }
    showable = {}
    for name, size in together.items():
        if name in reasons:
            continue
        by_one = {k: own[name].size if name in own else math.inf for k, own in alone.items()}
        # A size that one recording shows also shows in all together.
        least = min(size.size, *by_one.values())
        floor = CATALOGUE[name].floor(case.setting.excitation)
        showable[name] = Showable(size.parameter, size.unit, least, by_one, floor)
    return Excited(
        showable,
        tuple(NotTestable(name, reasons[name]) for name in CATALOGUE if name in reasons),
    )


def _probed(
    case: Case, library: Sequence[Candidate], progress: Callable[[float], None]
) -> list[Probe]:
    tried: list[Probe] = []
    for first in range(0, len(library), _CHUNK):
        progress(first / len(library))
        tried += probes(case.misfit, case.base, library[first : first + _CHUNK])
    return tried


def _sizes(
    case: Case, tried: Sequence[Probe], record: int | None
) -> tuple[dict[str, DetectableSize], dict[str, str]]:
    """Smallest sizes by effect in one recording or in all, and why others do not show."""
    whiteners = case.misfit.whiteners
    if record is not None:
        whiteners = tuple(w for w in whiteners if w.window.record == record)
    if not whiteners:
        return {}, {}
    misfit = case.misfit.with_whiteners(whiteners)
    base = case.base.measured_by(misfit)
    told = [screened(misfit, base, probe) for probe in tried]
    most: dict[str, float] = {}
    felt: dict[str, float] = {}
    for entry in told:
        name = entry.probe.candidate.effect
        most[name] = max(most.get(name, 0.0), entry.unlike_parameters)
        felt[name] = max(felt.get(name, 0.0), entry.information)
    alike = {
        name: "like [uncertain] parameters" if felt[name] > 0.0 else "changes nothing here"
        for name, share in most.items()
        if share < UNLIKE
    }
    return _detectable(case, told), alike


def _detectable(case: Case, told: Sequence[Screened]) -> dict[str, DetectableSize]:
    """Smallest size of each effect that would be told."""
    sizes: dict[str, DetectableSize] = {}
    excitation, units = case.setting.excitation, units_of(case)
    for entry in told:
        candidate = entry.probe.candidate
        law = candidate.law
        if entry.information <= 0.0 or candidate.searched > 1:
            continue  # several lines together show at a smaller size than any of them
        at_probe = entry.probe.at_probe
        smallest = law.size({**at_probe.more, **at_probe.values}, excitation)
        if all(entry.probe.amplitudes):
            smallest *= float(np.sqrt(TOLD_APART / entry.information))
        # Else a limit, which shows whole or not at all.
        smallest = max(smallest, law.floor(excitation))
        if law.name not in sizes or smallest < sizes[law.name].size:
            sizes[law.name] = DetectableSize(law.size_name, smallest, units.resolve(law.size_unit))
    return {name: sizes[name] for name in CATALOGUE if name in sizes}
