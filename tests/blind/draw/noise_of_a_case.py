"""Noise of a case in its columns, as a covariance by frequency, and differences whitened by it.

Noise of the encoder, counts included, goes round the loop into both columns; what the logger adds
stays in its own. How it goes round is measured on the true plant: small impulses at the encoder,
some time apart, while the axis moves as in the recording. Where the law makes that differ from
place to place the mean power counts: noise is stationary here. An axis in open loop runs on the
recorded command; noise of that column drives it, and noise of the encoder is seen as it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.blind.draw.remade import Remade, of_count
from tests.blind.truth import KINDS, PREROLL, Vector, simulate

Complex = NDArray[np.complexfloating]

APART = 600
"""Rows between two impulses: a loop has settled long before."""

_FIRST = 150
_SIZE = 3.0
"""Impulses, in standard deviations of the encoder's noise."""


@dataclass(frozen=True)
class Noise:
    """Inverse Cholesky factors of the noise of each recording.

    Attributes
    ----------
    factors : sequence of ndarray
        Shape (rows // 2 + 1, n_columns, n_columns) each.
    """

    factors: Sequence[Complex]

    def white(self, columns: Sequence[Vector], chosen: Sequence[int] | None = None) -> Vector:
        """Differences whitened: independent numbers, of unit variance where they are noise.

        Parameters
        ----------
        columns : sequence of ndarray, shape (rows, n_columns) each
            In the units of the noise.
        chosen : sequence of int, optional
            Which recordings they are of; all without it.
        """
        factors = self.factors if chosen is None else [self.factors[k] for k in chosen]
        parts = []
        for own, factor in zip(columns, factors, strict=True):
            rows = len(own)
            w = np.einsum("fij,fj->fi", factor, np.fft.rfft(own, axis=0)) * np.sqrt(2.0)
            w[0] /= np.sqrt(2.0)  # the mean is one real number where others are two
            if rows % 2 == 0:
                w[-1] /= np.sqrt(2.0)
            parts += [w.real.ravel(), w.imag.ravel()]
        return np.concatenate(parts)


def noise_of(covariances: Sequence[Complex]) -> Noise:
    """Noise of these covariances of the transforms of each recording.

    Parameters
    ----------
    covariances : sequence of ndarray, shape (rows // 2 + 1, n_columns, n_columns) each
        Of white noise of variance 1 it is the number of rows.
    """
    return Noise([np.linalg.inv(np.linalg.cholesky(own)) for own in covariances])


def noise_in(case: Remade) -> Noise:
    """Noise of all recordings of a case, as they are compared.

    Parameters
    ----------
    case : Remade
        What was drawn. Noise of rows that are read late, of filters of a column and of torque is
        not known here.
    """
    if case.machine.is_open_loop:
        return noise_of([_driven_noise(case, own) for own in case.clean(case.plant)])
    encoder = encoder_noise(case)
    covariances = []
    for k, one in enumerate(case.experiments):
        rows = len(one.reference)
        paths = impulses(case, k, encoder_noise(case) or case.machine.jitter)
        s = encoder**2 * np.einsum("kfi,kfj->fij", paths, paths.conj()) / len(paths)
        s[:, 0, 0] += _logged_position(case)
        s[:, 1, 1] += logged_command(case, rows)
        covariances.append(rows * of_a_stretch(s, rows))
    return noise_of(covariances)


def of_a_stretch(s: Complex, rows: int) -> Complex:
    """Expected periodogram of a stretch of noise: a spectrum that its ends have smeared.

    A loop takes slow noise of the encoder out of the reading, and a stretch is cut out of it: what
    is left at low frequencies is of its two ends. By the correlation times 1 - |lag| / rows.

    Parameters
    ----------
    s : ndarray, shape (rows // 2 + 1, n, n)
        Spectrum.
    rows : int
        Of the stretch.
    """
    lag = np.minimum(np.arange(rows), rows - np.arange(rows))
    # Correlations of two columns are real, and even only with their transpose: all lags are kept.
    shape = (-1, 1, 1)
    correlation = np.fft.irfft(s, n=rows, axis=0) * (1.0 - lag / rows).reshape(shape)
    return np.asarray(np.fft.rfft(correlation, axis=0))


def encoder_noise(case: Remade) -> float:
    """[position] Standard deviation of what the controller reads beside the position."""
    own = case.machine
    return 0.0 if case.rig.loop_is_clean else float(np.hypot(own.jitter, of_count(own.quantum)))


def _logged_position(case: Remade) -> float:
    """[position^2] Variance of what the logger adds to the position."""
    return case.rig.position_noise**2 + of_count(case.rig.position_count) ** 2


def logged_command(case: Remade, rows: int) -> Vector:
    """[command^2] Power of what the logger adds to the command, by frequency."""
    logger, power = case.logger, np.full(rows // 2 + 1, case.machine.command_noise**2)
    if logger.colour:  # as `recording.Logger.noise` makes it
        turn = np.exp(-2j * np.pi * np.fft.rfftfreq(rows))
        power *= 9.0 * (1.0 - logger.colour**2) / np.abs(1.0 - logger.colour * turn) ** 2
    return logger.scale**2 * power + of_count(case.rig.command_count) ** 2


def impulses(case: Remade, record: int, size: float) -> Complex:
    """Transforms of both columns by unit impulses at the encoder, shape (n, frequencies, 2).

    Parameters
    ----------
    case : Remade
        What was drawn.
    record : int
        Recording.
    size : float
        [position] Standard deviation of the encoder's noise.
    """
    one = case.experiments[record]
    rows, values = len(one.reference), {**case.plant, **one.gains}
    noise, at = np.zeros(PREROLL + rows), np.arange(_FIRST, rows - APART, APART)
    noise[PREROLL + at] = _SIZE * size
    moved, still = (simulate(values, one.reference, own) for own in (noise, None))
    names = ("reading", "new" if case.logger.convention == "new" else "held")
    apart = np.column_stack([getattr(moved, n) - getattr(still, n) for n in names])
    apart[:, 1] *= case.logger.scale
    padded = np.zeros((len(at), rows, 2))
    for own, start in zip(padded, at, strict=True):
        own[:APART] = apart[start : start + APART] / (_SIZE * size)
    return np.fft.rfft(padded, axis=1)


def _driven_noise(case: Remade, shown: Vector) -> Complex:
    """Of a position in open loop, filtered as it is compared: encoder and recorded command."""
    rows, size = len(shown), case.machine.command_noise
    at = np.arange(_FIRST, rows - APART, APART)
    power = np.zeros(rows // 2 + 1)
    quiet = driven(case.plant, shown)
    for start in at:  # one at a time: a plant in open loop does not forget
        pushed = shown.copy()
        pushed[start, 1] += _SIZE * size
        apart = (driven(case.plant, pushed) - quiet)[:, None] / (_SIZE * size)
        power += np.abs(np.fft.rfft(case.oracle.compared(apart)[:, 0])) ** 2 / len(at)
    impulse = np.zeros((rows, 1))
    impulse[0] = 1.0
    seen = np.abs(np.fft.rfft(case.oracle.compared(impulse)[:, 0])) ** 2
    own = encoder_noise(case) ** 2 + _logged_position(case)
    command = logged_command(case, rows)
    return np.asarray(rows * (own * seen + command * power))[:, None, None].astype(complex)


def driven(values: Mapping[str, float], recorded: Vector) -> Vector:
    """Position of the plant under a recorded command, from the first recorded position.

    Parameters
    ----------
    values : mapping of str to float
        Of the plant.
    recorded : ndarray, shape (rows, 2)
        Position, and the command that is new at each row.
    """
    alone = {**values, "kind": KINDS["none"], "start": float(recorded[0, 0])}
    return simulate(alone, recorded[:, 1], preroll=0).reading
