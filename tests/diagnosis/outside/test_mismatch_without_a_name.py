"""When a misfit that nothing explains is called one, by numbers."""

from __future__ import annotations

import pytest

from gmfbo.diagnosis.outside.beyond_library import FAR, MISMATCH, is_mismatch
from gmfbo.diagnosis.result.reference_test import ResidualTest

ERRORS = {"position": 0.010}


def followed(share: float, bound: float = 0.001, tolerance: float = 0.001) -> list[ResidualTest]:
    """One recording whose residual follows the reference by a share of the range."""
    return [ResidualTest("run3.csv", "position", 0.01, share, bound, tolerance)]


def test_much_that_follows_the_reference_is_a_mismatch() -> None:
    assert is_mismatch(1.01 * MISMATCH, followed(0.008), ERRORS)


def test_ten_times_the_noise_is_one_whatever_it_follows() -> None:
    assert is_mismatch(1.01 * FAR, followed(0.0), ERRORS)
    assert is_mismatch(1.01 * FAR, [], ERRORS)
    assert not is_mismatch(0.99 * FAR, followed(0.0), ERRORS)


@pytest.mark.parametrize(
    ("left", "tests"),
    [
        pytest.param(0.99 * MISMATCH, followed(0.008), id="little is left"),
        pytest.param(
            9.0 * MISMATCH, followed(0.004), id="coloured noise with a slightly wrong gain"
        ),
        pytest.param(9.0 * MISMATCH, followed(0.008, bound=0.01), id="chance would follow as much"),
        pytest.param(9.0 * MISMATCH, followed(0.008, tolerance=0.01), id="within the tolerance"),
        pytest.param(9.0 * MISMATCH, [], id="nothing held out"),
    ],
)
def test_what_else_is_left_is_none(left: float, tests: list[ResidualTest]) -> None:
    assert not is_mismatch(left, tests, ERRORS)
