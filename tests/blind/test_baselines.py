"""The baselines find what is easy to find, each by its own means."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.blind.cases import make_case
from tests.blind.plan import Plan
from tests.blind.refits import Refits
from tests.blind.sparse_regression import _thresholded


def test_sparse_regression_keeps_the_terms_that_are_there() -> None:
    rng = np.random.default_rng(0)
    a, v, q = rng.standard_normal((3, 4000))
    features = {
        "acceleration": a,
        "velocity": v,
        "elastic_return": q,
        "quadratic_drag": v * np.abs(v),
    }
    target = 2.0 * a + 0.1 * v + 0.5 * q + 1e-3 * rng.standard_normal(4000)
    assert _thresholded(features, target) == ["acceleration", "velocity", "elastic_return"]


@pytest.mark.slow
def test_a_process_on_the_residual_mends_unseen_runs_where_a_spring_is_missing(
    tmp_path: Path,
) -> None:
    """And changes little where nothing is: its own scatter stays below a fifth."""
    for effects, low, high in ((("elastic_return",), 0.0, 0.8), ((), 0.8, 1.2)):
        folder = tmp_path / (effects or ("null",))[0]
        make_case(Plan("single" if effects else "null", "servo", effects), 31, 1, folder)
        with Refits(folder, "rec1.csv") as refits:
            assert low < refits.gp_ratio() < high
            assert refits.simulations > 0


@pytest.mark.slow
@pytest.mark.parametrize(("index", "band"), [(0, "below"), (1, "around"), (2, "above")])
def test_a_size_is_found_for_the_gain_that_was_drawn(index: int, band: str, tmp_path: Path) -> None:
    """The oracle's gain of a case is within a factor of 1.6 of its target in each band."""
    plan = Plan("single", "servo", ("cogging_torque",), band=band)
    answer = make_case(plan, 41, index, tmp_path / f"{index:03d}")
    assert answer.oracle_gain == pytest.approx(answer.target_gain[0], rel=0.6)
