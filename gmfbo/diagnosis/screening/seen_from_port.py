"""Whitened residuals seen from a port: how much each instant there would explain of them.

With x = W G d the whitened change by a signal d at the port, the field a = G' W' r gives r'x as
the sum of a*d: features without number are tried on a residual at the cost of one sum each.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal.windows import tukey

from gmfbo.diagnosis.fitting.misfit import Blocks, Misfit
from gmfbo.diagnosis.scoring.whitening import Spectrum, Whitener
from gmfbo.diagnosis.screening.port_response import PortResponse

Array = NDArray[np.float64]


def fields(misfit: Misfit, response: PortResponse, residual: Blocks) -> list[Array]:
    """Field of each recording at the port, shape (rows,)."""
    records = misfit.simulations.records
    signals = [[np.zeros(s.values.size) for s in record.signals] for record in records]
    for whitener, block in zip(misfit.whiteners, residual, strict=True):
        own = signals[whitener.window.record]
        for column, rows, values in zip(
            own, whitener.window.rows, unwhitened(whitener, block), strict=True
        ):
            column[rows] += values
    return [response.backwards(k, columns) for k, columns in enumerate(signals)]


def unwhitened(whitener: Whitener, block: Array) -> list[Array]:
    """Transpose of `Whitener.whiten`: one array a signal, over the window's rows.

    Parameters
    ----------
    whitener : Whitener
        Of a window.
    block : ndarray, shape (n_residuals,)
        Whitened values.
    """
    window = whitener.window
    coloured = _gather(whitener, _deflated(whitener, block))
    spectrum = np.einsum("fji,fj->fi", _factor(whitener).conj(), coloured) * window.seen
    columns = []
    for signal, rows in enumerate(window.rows):
        n = rows.stop - rows.start
        bins = min(window.frequencies.size, n // 2 + 1)
        half = np.zeros(n // 2 + 1, dtype=complex)
        half[:bins] = spectrum[:bins, signal]
        # irfft sums each bin and its mirror image; the transpose of rfft sums each bin once.
        half[1:] *= 0.5
        if n % 2 == 0 and bins == half.size:
            half[-1] *= 2.0
        columns.append(np.fft.irfft(half, n) * tukey(n, 0.1))
    return columns


def _gather(whitener: Whitener, block: Array) -> Spectrum:
    """Transpose of `Whitener.flatten`."""
    seen = whitener.window.seen
    count, (bins, signals) = int(seen[1:].sum()), seen.shape
    coloured = np.zeros((bins, signals), dtype=complex)
    coloured[0] = block[:signals]
    parts = block[signals : signals + count] + 1j * block[signals + count :]
    coloured[1:][seen[1:]] = np.sqrt(2.0) * parts
    return coloured


def _factor(whitener: Whitener) -> Spectrum:
    """Matrix of `Whitener.colour` at each frequency."""
    window = whitener.window
    n = window.n_signals
    units = np.broadcast_to(np.eye(n)[:, None, :], (n, window.frequencies.size, n))
    factor: Spectrum = np.moveaxis(whitener.colour(units.astype(complex)), 0, -1)
    return factor


def _deflated(whitener: Whitener, block: Array) -> Array:
    """Leave the nuisances out a second time: that projection is its own transpose."""
    if whitener.nuisances is None or not len(whitener.nuisances):
        return block
    _, sizes, basis = np.linalg.svd(whitener.nuisances, full_matrices=False)
    shares = 1.0 - 1.0 / np.sqrt(1.0 + sizes**2)
    out: Array = block - ((basis @ block) * shares) @ basis
    return out


def whitened_columns(misfit: Misfit, response: PortResponse, columns: Sequence[Array]) -> Blocks:
    """Whitened changes by signals at the port, shape (n, n_residuals) a window.

    Parameters
    ----------
    misfit : Misfit
        With the whiteners.
    response : PortResponse
        From the port to the signals.
    columns : sequence of ndarray, shape (n, rows)
        [port's unit] One array a recording.
    """
    return misfit.whitened([response.filtered(k, column) for k, column in enumerate(columns)])
