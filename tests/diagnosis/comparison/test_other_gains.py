"""Recordings that were never fitted may have other gains, and so other noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.comparison.held_out_fit import ledger_on, quiet, seen_on
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from tests.diagnosis.noise.planted_noise import opened, planted
from tests.diagnosis.short_recordings import SERVO

SIGMA = 3e-4  # [rad]


def test_unseen_recordings_are_whitened_by_the_noise_of_their_own_gains() -> None:
    softer = replace(SERVO, gains={name: 0.4 * value for name, value in SERVO.gains.items()})
    with opened(planted(SIGMA)) as case, opened(planted(SIGMA, axis=softer, seed=5)) as unseen:
        search = (stated := comparison_of(case, [])).search
        ledger = search.opened(stated.first)
        row = ledger.rows[frozenset()]
        windows = range(len(unseen.budget.windows))
        run = quiet(unseen, row)
        part = seen_on(unseen, search, ledger_on(unseen, search, ledger, row), run, windows, ())
    white = np.concatenate([z.ravel() for z in part.whitening(part.fitted.residual)])
    # Levels that were read at one gain are a little off at another; by the paths of the first gains
    # it would be ten.
    assert 0.8 < float(np.mean(white[white != 0.0] ** 2)) < 1.25
