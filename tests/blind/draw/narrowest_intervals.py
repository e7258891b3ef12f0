"""The narrowest interval that the recordings of a case allow, by Cramer and Rao.

The bound of an unbiased estimate is the square root of g^T (J^T J)^-1 g: J holds the whitened
derivatives of all recordings by what is free at the truth (values of the hidden laws, the twin's
uncertain parameters, and the nuisances where they count as unknown), g the gradient of the value
that is told (Kay 1993, "Fundamentals of Statistical Signal Processing", eq. 3.30).

It leaves out what makes an honest interval wider: that the library's formula is not the plant's,
that the form of a contact and of Stribeck's curve, the step of the simulation, the clock and the
level of the noise are unknown, that a recording's noise is dithered by the law, that the name is a
guess, and what a twin file says of a parameter's range.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tests.blind.draw.fit_of_the_true_law import TrueLaw
from tests.blind.draw.law_coordinates import reported
from tests.blind.draw.measures import NORMAL
from tests.blind.draw.noise_of_a_case import Noise, noise_in
from tests.blind.draw.prediction_errors import PredictionErrors
from tests.blind.truth import SAMPLE, Vector

_BLIND = 1e-6
"""Singular value, of derivatives of unit length, below which a direction cannot be told."""

_ALONG = 1e-4
"""Share of a gradient along such a direction from which on a value has no bound."""


@dataclass(frozen=True)
class Narrowest:
    """Width of the narrowest interval of 95 %, in the unit of the value; infinite without one.

    Attributes
    ----------
    width : float
        Where offset, scale and shift of the logged columns are unknown too.
    width_without : float
        Where the columns are known to be right.
    width_by_frequency : float
        Of an estimate that compares closed loops by their spectra, and takes the frequencies of a
        recording as independent; columns are unknown.
    """

    width: float
    width_without: float
    width_by_frequency: float


def narrowest(law: TrueLaw, names: list[str], fmu_names: Mapping[str, str]) -> dict[str, Narrowest]:
    """Widths of the narrowest intervals of some values.

    Parameters
    ----------
    law : TrueLaw
        The plant with all free that a fit of the true law moves.
    names : list of str
        Values, as `law_coordinates.reported` reads them.
    fmu_names : mapping of str to str
        Plant parameter by FMU name.
    """
    spectral = by_frequency(law)
    if law.case.machine.is_open_loop:
        # Noise of a recorded command drives the plant: its spectrum is all that is known of it.
        exact, known = spectral, _open_loop(law)
    else:
        errors = PredictionErrors(law)
        known = np.hstack([errors.by_values(), errors.by_starts()])
        exact = np.hstack([known, errors.by_columns()])
    found = {}
    for name in names:
        along = gradient(law, name, fmu_names)
        sizes = [
            2.0 * NORMAL * standard_error(own, np.pad(along, (0, own.shape[1] - len(along))))
            for own in (exact, known, spectral)
        ]
        found[name] = Narrowest(*sizes)
    return found


def by_frequency(law: TrueLaw) -> Vector:
    """Derivatives whitened frequency by frequency: by what is free, starts and columns.

    A position in open loop may be shifted; its scale is that of all torques there, and would leave
    nothing to tell.
    """
    if law.case.machine.is_open_loop:
        shown = [one[:, :1] for one in law.shown]
        shifted = [law.case.oracle.compared(np.gradient(one, SAMPLE, axis=0)) for one in shown]
        return np.column_stack([_open_loop(law), noise_in(law.case).white(shifted)])
    noise, columns = noise_in(law.case), []
    for own in np.eye(2):
        columns += [
            noise.white([make(one) * own for one in law.shown])
            for make in (np.ones_like, np.asarray, _rate)
        ]
    return np.column_stack([_white(law, noise), *columns])


def _rate(columns: Vector) -> Vector:
    return np.asarray(np.gradient(columns, SAMPLE, axis=0))


def _open_loop(law: TrueLaw) -> Vector:
    """Derivatives of an open loop by what is free, and by place and speed at each start."""
    noise, columns = noise_in(law.case), []
    starts = law.starts([len(one) for one in law.shown])
    for k, own in enumerate(starts):
        for wave in own.T:
            moved = [np.zeros((len(one), 1)) for one in law.shown]
            moved[k] = law.case.oracle.compared(wave[:, None])
            columns.append(noise.white(moved))
    return np.column_stack([_white(law, noise), *columns])


def _white(law: TrueLaw, noise: Noise) -> Vector:
    """By what is free, shape (n, n_free)."""
    count = len(law.free.groups)
    columns = [noise.white([own[:, :, k] for own in law.slopes]) for k in range(count)]
    rows = 2 * sum(factor.shape[0] * factor.shape[1] for factor in noise.factors)
    return np.array(columns).reshape(count, rows).T


def gradient(law: TrueLaw, name: str, fmu_names: Mapping[str, str]) -> Vector:
    """Derivative of a told value by the free ones, shape (n_free,)."""
    steps, known = 1e-5 * np.eye(len(law.free.groups)), law.case.values
    # What the plant holds without the law stays known: a law's own viscosity is told beside it.
    ahead, behind = (
        [reported(name, law.free.at(sign * one), known, fmu_names) for one in steps]
        for sign in (1.0, -1.0)
    )
    return np.subtract(ahead, behind) / 2e-5


def standard_error(slopes: Vector, along: Vector) -> float:
    """Least standard deviation of an unbiased estimate of a combination of free values.

    Parameters
    ----------
    slopes : ndarray, shape (n, n_free)
        Whitened derivatives.
    along : ndarray, shape (n_free,)
        Gradient of the combination.
    """
    size = np.linalg.norm(slopes, axis=0)
    if np.any((size == 0.0) & (along != 0.0)):
        return float("inf")
    kept = size > 0.0
    _, singular, turned = np.linalg.svd(slopes[:, kept] / size[kept], full_matrices=False)
    parts = turned @ (along[kept] / size[kept])
    is_blind = singular < _BLIND * singular[0]
    if np.linalg.norm(parts[is_blind]) > _ALONG * np.linalg.norm(parts):
        return float("inf")
    return float(np.linalg.norm(parts[~is_blind] / singular[~is_blind]))
