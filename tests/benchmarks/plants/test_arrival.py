from __future__ import annotations

import numpy as np
import pytest

from tests.benchmarks.plants.arrival import (
    CAP,
    Arrivals,
    clearly_worse,
    never_difference,
    ratio_of_means,
    runs_to_target,
)
from tests.benchmarks.plants.evolution import cma_es


@pytest.mark.parametrize(
    ("true", "expected"),
    [
        ([0.0, 0.0, 0.0], 1),  # met right after the initial runs: one run
        ([1.0, 0.0, 0.0], 1),
        ([1.0, 1.0, 0.0], 2),
        ([0.0, 1.0, 0.0], 2),  # it has to stay
        ([0.0, 0.0, 1.0], None),
        ([None, None, 0.0], 2),
        ([0.0, None], None),
        ([], None),
    ],
)
def test_a_target_counts_from_where_the_recommendation_stays(
    true: list[float | None], expected: int | None
) -> None:
    assert runs_to_target(true, 0.5) == expected


def lines(method: str, runs: list[int]) -> list[dict[str, object]]:
    return [
        {"plant": "p", "method": method, "seed": seed, "true": [1.0] * count + [0.0]}
        for seed, count in enumerate(runs)
    ]


def test_a_ratio_of_equal_methods_is_one_and_of_half_the_runs_a_half() -> None:
    made = [*lines("a", [2, 4, 6]), *lines("b", [4, 8, 12]), *lines("c", [4, 8, 12])]
    arrivals = Arrivals.of(made, {"p": 0.5})
    assert ratio_of_means(arrivals, ["p"], "b", ["c"]) == pytest.approx((1.0, 1.0, 1.0))
    ratio, low, high = ratio_of_means(arrivals, ["p"], "a", ["b", "c"])
    assert ratio == pytest.approx(0.5)
    assert low <= ratio <= high


def test_only_who_is_slower_by_more_than_the_margin_is_clearly_worse() -> None:
    rng = np.random.default_rng(1)
    slow = [int(n) for n in 9 + rng.integers(3, size=20)]
    made = [*lines("a", slow), *lines("b", [2 + n % 3 for n in slow]), *lines("c", slow)]
    arrivals = Arrivals.of(made, {"p": 0.5})
    assert clearly_worse(arrivals, ["p"], "a", ["b", "c"], 1.5) == [("p", "b")]
    assert clearly_worse(arrivals, ["p"], "a", ["b", "c"], 9.0) == []
    assert clearly_worse(arrivals, ["p"], "b", ["a", "c"], 1.5) == []


def test_the_share_that_never_arrives_is_less_by_what_arrived_more() -> None:
    made = [
        {"plant": "p", "method": method, "seed": seed, "true": [1.0, float(seed >= arrived)]}
        for method, arrived in (("a", 8), ("b", 4), ("c", 2))
        for seed in range(10)
    ]
    arrivals = Arrivals.of(made, {"p": 0.5})
    less, low, high = never_difference(arrivals, ["p"], "a", ["b", "c"])
    assert less == pytest.approx(-0.4)
    assert low <= less <= high < 0.0


def test_who_never_arrives_counts_as_the_cap() -> None:
    made = [{"plant": "p", "method": "a", "seed": 0, "true": [1.0, 1.0]}]
    arrivals = Arrivals.of(made, {"p": 0.5})
    assert arrivals.capped("p", "a", [0]).tolist() == [CAP]
    assert arrivals.never(["p"], "a") == 1.0


def test_cma_es_finds_the_least_of_a_tilted_valley() -> None:
    least = np.array([0.3, 0.7, 0.5])
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    scales = np.array([1.0, 10.0, 100.0])

    def cost(point: np.ndarray) -> float:
        return float(np.sum(scales * (turn @ (point - least)) ** 2))

    assert cma_es(cost, np.full(3, 0.5), generations=200) == pytest.approx(least, abs=1e-3)
