"""A simpler law is never left where a search gave it up, beside a larger one that holds it."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import pytest

from gmfbo.diagnosis.comparison.modes.posterior_mode import ModeSearch
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.row_fits import RowFits, begun_as_larger, chi
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from tests.diagnosis.short_recordings import SERVO, moves, open_small
from tests.physics.excitations import TYPICAL

LEVEL, SIMPLE, LARGER = 0.05, frozenset({"coulomb_friction"}), frozenset({"asymmetric_friction"})


def test_a_fit_that_was_given_up_begins_again_as_the_larger_law_is() -> None:
    made = SERVO.recordings({"coulomb_friction.level": LEVEL}, (moves,))
    with closing((case := open_small(SERVO.twin(), made)).simulations):
        comparison = comparison_of(case, [*SIMPLE, *LARGER])
        ledger, _ = comparison.run()
        search, larger, whitening = comparison.search, ledger.rows[LARGER], ledger.whitening
        assert begun_as_larger(ledger, larger) == []
        fitted = ledger.rows[SIMPLE]
        far = fitted.hypothesis.at(fitted.x).effects[0].with_values({"level": 20.0 * LEVEL})
        there = replace(fitted.hypothesis, effects=(far.with_nuisances(TYPICAL),))
        begun = ModeSearch(search.problem, whitening, there).begun(fitted.parameters, None, None)
        assert begun is not None
        left = replace(ledger, rows={**ledger.rows, SIMPLE: begun})
        [(about, again)] = begun_as_larger(left, larger)
        fits = RowFits(search.problem, ledger.noise_of)
        found = fits.with_moves(left, about, again, larger)[SIMPLE]
    assert about.elements == frozenset()
    assert chi(begun, whitening) > chi(fitted, whitening) + 100.0
    assert chi(found, whitening) == pytest.approx(chi(fitted, whitening), abs=4.0)


def test_a_law_as_its_limit_has_the_values_that_the_limit_names() -> None:
    friction = Candidate("stribeck_friction", {"level": 0.1, "breakaway": 0.1, "velocity": 2.0})
    limit = friction.as_limit("coulomb_friction", TYPICAL)
    assert limit is not None
    assert limit.values["level"] == 0.1
    assert "breakaway" not in limit.values
    assert Candidate("coulomb_friction", {"level": 0.1}).as_limit("backlash", TYPICAL) is None
