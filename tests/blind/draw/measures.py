"""What a table says of many cases beyond counts: calibration, clustered shares, error left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, logit
from scipy.stats import beta

from gmfbo.diagnosis.naming.worth import LAST_DIGIT

RESAMPLED = 2000

NORMAL = 1.959964
"""Standard errors on either side that hold 95 % of a normal distribution."""

LEAST = 0.2
"""Least excess of squared errors over squared noise that an error is shared out for."""

Vector = NDArray[np.float64]


def recalibration(stated: Sequence[float], right: Sequence[bool]) -> tuple[Vector, Vector] | None:
    """Intercept and slope of what came true over what was stated, with standard errors.

    P(right) = expit(intercept + slope logit(stated)), by maximum likelihood (Cox 1958,
    "Two further applications of a model for binary regression", eq. 1). An honest forecast has
    intercept 0 and slope 1.

    Parameters
    ----------
    stated : sequence of float
        Probabilities. Above 0.995 and below 0.005 they count as these: no more is printed.
    right : sequence of bool
        Whether each came true.

    Returns
    -------
    tuple of ndarray or None
        Values and standard errors, each of shape (2,), intercept first; None where the claims
        cannot tell them: all or none are right, all probabilities alike, or each below some
        probability is wrong and each above it right.
    """
    p = np.clip(np.asarray(stated, dtype=float), LAST_DIGIT, 1.0 - LAST_DIGIT)
    y = np.asarray(right, dtype=float)
    if len(p) == 0 or np.ptp(y) == 0.0 or np.ptp(p) == 0.0:
        return None
    a = np.column_stack([np.ones(len(p)), logit(p)])
    if a[y == 1.0, 1].min() >= a[y == 0.0, 1].max() or a[y == 0.0, 1].min() >= a[y == 1, 1].max():
        return None
    x = np.array([0.0, 1.0])
    loss = _loss(a, y, x)
    for _ in range(100):
        q = expit(a @ x)
        information = (a * (q * (1.0 - q))[:, None]).T @ a
        step = np.linalg.solve(information, a.T @ (y - q))
        while (new := _loss(a, y, x + step)) > loss + 1e-12:
            step *= 0.5
        x, loss = x + step, new
        if np.max(np.abs(step)) < 1e-10:
            break
    return x, np.sqrt(np.diag(np.linalg.inv(information)))


def _loss(a: Vector, y: Vector, x: Vector) -> float:
    return float(np.sum(np.logaddexp(0.0, a @ x) - y * (a @ x)))


def clopper_pearson(count: int, total: int, level: float = 0.95) -> tuple[float, float]:
    """Exact interval of a share (Clopper, Pearson 1934), both tails alike.

    Parameters
    ----------
    count, total : int
        Successes, and trials.
    level : float
        Coverage.
    """
    if total == 0:
        return 0.0, 1.0
    tail = 0.5 * (1.0 - level)
    low = float(beta.ppf(tail, count, total - count + 1)) if count else 0.0
    high = float(beta.ppf(1.0 - tail, count + 1, total - count)) if count < total else 1.0
    return low, high


def clustered_share(held: Sequence[bool], clusters: Sequence[object]) -> tuple[float, float]:
    """Interval of 95 % of a share whose trials come in clusters, by drawing clusters again.

    Parameters
    ----------
    held : sequence of bool
        What is counted.
    clusters : sequence of hashable
        That each belongs to, such as its machine and law.
    """
    if not held:
        return 0.0, 1.0
    names = {name: k for k, name in enumerate(dict.fromkeys(clusters))}
    if all(held) or not any(held) or len(names) == 1:
        # Drawing again shows no scatter: as many trials as there are clusters, all alike or not.
        share = sum(held) / len(held)
        return clopper_pearson(round(share * len(names)), len(names))
    of = np.array([names[name] for name in clusters])
    hits = np.bincount(of, np.asarray(held, dtype=float), len(names))
    sizes = np.bincount(of, minlength=len(names))
    drawn = np.random.default_rng(0).integers(0, len(names), (RESAMPLED, len(names)))
    shares = hits[drawn].sum(axis=1) / sizes[drawn].sum(axis=1)
    low, high = np.quantile(shares, [0.025, 0.975])
    return float(low), float(high)


def error_left(diagnosis: Mapping[str, Any]) -> float | None:
    """Share of the explainable error that is left on recordings that were never fitted.

    (E_aug^2 - E_noise^2) / (E_par^2 - E_noise^2), each signal's errors in units of its noise,
    summed over the signals. Where nothing is named the twin stays, and all is left.

    Parameters
    ----------
    diagnosis : mapping
        Content of diagnosis.json.

    Returns
    -------
    float or None
        None where parameters alone leave hardly more than noise (a tenth of the error, in one
        signal): noise of held-out rows would decide the ratio.
    """
    signals = ((diagnosis.get("fit") or {}).get("signals") or {}).values()
    whole = left = 0.0
    for errors in signals:
        noise, par = errors.get("noise_floor"), errors.get("parameters_only")
        if not noise or par is None:
            continue
        aug = errors.get("augmented")
        whole += (par / noise) ** 2 - 1.0
        left += ((par if aug is None else aug) / noise) ** 2 - 1.0
    return left / whole if whole > LEAST else None
