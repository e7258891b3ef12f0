"""Which parameters a range holds: told by the gradient at its end (Karush, Kuhn, Tucker)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis, Setting
from gmfbo.diagnosis.fitting.range_ends import ends_reached
from gmfbo.diagnosis.result.estimated import Side
from gmfbo.sources.twin.uncertain import Uncertain
from tests.physics.excitations import TYPICAL

RANGES = {"a": (0.0, 1.0), "b": (0.0, 1.0)}
OWN = tuple(Uncertain(name, 0.5, low, high) for name, (low, high) in RANGES.items())


def best_within_ranges(truth: tuple[float, float]) -> Fitted:
    """Exact least squares under bounds, by SciPy's solver for linear problems."""
    rng = np.random.default_rng(2)
    columns = rng.standard_normal((2, 80))
    data = columns.T @ np.array(truth)
    x = np.asarray(lsq_linear(columns.T, data, bounds=(0.0, 1.0), method="bvls").x)
    residual = data - columns.T @ x
    return Fitted(Hypothesis(Setting(OWN, TYPICAL)), x, [], (residual,), (columns,), [])


@pytest.mark.parametrize(
    ("truth", "ends"),
    [
        ((1.5, 0.4), {"a": "high"}),
        ((0.6, -0.2), {"b": "low"}),
        ((1.2, -3.0), {"a": "high", "b": "low"}),
    ],
)
def test_a_value_that_a_bound_holds_is_told(
    truth: tuple[float, float], ends: dict[str, Side]
) -> None:
    assert ends_reached(best_within_ranges(truth), RANGES) == ends


def test_control_values_within_the_range_are_at_no_end() -> None:
    assert ends_reached(best_within_ranges((0.97, 0.04)), RANGES) == {}


def test_control_a_value_near_an_end_that_the_data_pull_inward_is_not_held() -> None:
    fitted = best_within_ranges((0.7, 0.5))
    near = Fitted(
        fitted.hypothesis,
        np.array([0.995, 0.5]),
        [],
        (fitted.residual[0] - 0.295 * fitted.sensitivity[0][0],),
        fitted.sensitivity,
        [],
    )
    assert ends_reached(near, RANGES) == {}


def test_a_value_beyond_a_narrower_range_is_told() -> None:
    fitted = best_within_ranges((0.8, 0.5))
    assert ends_reached(fitted, {"a": (0.0, 0.6), "b": (0.0, 1.0)}) == {"a": "high"}
