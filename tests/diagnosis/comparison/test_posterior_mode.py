"""A search for best values goes as far as it can matter."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.posterior_mode import ModeSearch
from gmfbo.diagnosis.comparison.row_fits import cost
from tests.diagnosis.noise.planted_noise import opened, planted

SIGMA = 3e-4  # [rad]


def test_what_stays_far_behind_the_best_fit_is_not_searched_on() -> None:
    with opened(planted(SIGMA)) as case:
        search = (stated := comparison_of(case, [])).search
        ledger = search.opened(stated.first)
        base = ledger.rows[frozenset()]
        wrong = {name: 1.5 * value for name, value in base.parameters.items()}
        fit = ModeSearch(search.problem, ledger.whitening, base.hypothesis)
        best = cost(base, ledger.whitening)
        behind = fit.fitted(wrong, rival=best - 1e9)
        level = fit.fitted(wrong, rival=best)
    assert behind is not None
    assert level is not None
    np.testing.assert_allclose(behind.x, list(wrong.values()), rtol=1e-4)
    assert not behind.converged
    assert level.converged
    assert cost(level, ledger.whitening) == pytest.approx(best, abs=0.2)
