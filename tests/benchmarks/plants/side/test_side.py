"""Rivals of the side table do what their names say."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from gmfbo.recordings.recording import Recording
from gmfbo.surrogate.axis_residual import AxisRuns
from gmfbo.tuning.methods import gmfbo
from tests.benchmarks.plants.catalogue import PLANTS
from tests.benchmarks.plants.side.ax_default import AxDefault
from tests.benchmarks.plants.side.constrained_ei import ConstrainedEi
from tests.benchmarks.plants.side.is3_variants import UncorrectedGmfbo
from tests.benchmarks.plants.side.nelder_mead import EDGE, NelderMead, next_point
from tests.benchmarks.plants.side.rivals import RIVALS
from tests.benchmarks.plants.side.turbo import FIRST, candidates, edge
from tests.benchmarks.plants.side_table import PARTS, noisier
from tests.benchmarks.plants.truths.conditions import Conditions


def bowl(point: np.ndarray) -> float:
    """A cost whose least value lies inside the unit cube."""
    return float((point[0] - 0.7) ** 2 + 3.0 * (point[1] - 0.4) ** 2)


def of_runs(points: list[np.ndarray]) -> Any:
    """What a method reads of a study whose real runs were made at points."""
    runs = [SimpleNamespace(point=one, objective=bowl(one), counts=True) for one in points]
    return SimpleNamespace(of=lambda source: runs, hold=np.asarray, space=points[0])


def test_the_simplex_search_asked_run_by_run_is_that_of_scipy() -> None:
    start, edges = np.array([0.2, 0.8]), np.diag([EDGE, -EDGE])
    wanted: list[np.ndarray] = []

    def noted(point: np.ndarray) -> float:
        wanted.append(point.copy())
        return bowl(point)

    minimize(
        noted,
        start,
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * 2,
        options={"initial_simplex": np.vstack([start, start + edges]), "maxfev": 30},
    )
    costs: list[float] = []
    for point in wanted:
        asked = next_point(start, costs)
        assert asked is not None
        np.testing.assert_allclose(asked, point)
        costs.append(bowl(asked))


def test_the_simplex_search_leaves_out_the_second_initial_run() -> None:
    method, points = NelderMead(), [np.array([0.2, 0.8]), np.array([0.9, 0.1])]
    for _ in range(25):
        asked = method.propose(of_runs(points), np.random.default_rng(0))
        assert asked is not None
        points.append(asked.point)
    found, cost, _ = method.recommend(of_runs(points))
    assert cost < 1e-3
    np.testing.assert_allclose(found, [0.7, 0.4], atol=0.03)


def test_a_trust_region_doubles_after_three_better_runs_and_halves_after_four_others() -> None:
    better = np.array([5.0, 4.0, 3.0, 2.0, 1.0])
    assert edge(better, 2, 2) == 2.0 * FIRST
    worse = np.concatenate([better, np.full(4, 9.0)])
    assert edge(worse, 2, 2) == FIRST
    assert edge(worse, 6, 2) == 2.0 * FIRST  # six gains are given six runs


def test_points_of_a_trust_region_lie_in_it_and_differ_from_its_centre() -> None:
    centre, low, high = np.full(30, 0.5), np.full(30, 0.4), np.full(30, 0.7)
    drawn = candidates(centre, low, high, seed=3)
    assert np.all((drawn >= low) & (drawn <= high))
    assert np.all(np.any(drawn != centre, axis=1))
    assert np.mean(drawn != centre) == pytest.approx(20.0 / 30.0, abs=0.01)


def test_how_far_a_run_left_its_envelope_is_in_widths_of_it() -> None:
    method = ConstrainedEi({"position": (-1.0, 3.0)})
    inside = Recording(np.arange(3.0), {"position": np.array([0.0, 1.0, 2.0])})
    outside = Recording(np.arange(3.0), {"position": np.array([0.0, 5.0, np.nan])})
    trial = SimpleNamespace(recording=inside)
    assert method.beyond(trial) == -0.25  # type: ignore[arg-type]
    assert method.beyond(SimpleNamespace(recording=outside)) == 0.5  # type: ignore[arg-type]


def test_without_corrections_real_trajectories_tell_nothing(monkeypatch: Any) -> None:
    seen = []

    def told(self: Any, state: Any, rng: Any) -> None:
        runs, _ = gmfbo.__dict__["axis_runs"](state, np.arange(2.0))
        seen.append(runs)
        raise RuntimeError

    values = np.zeros((2, 2))
    monkeypatch.setattr(gmfbo.Gmfbo, "propose", told)

    def before(state: Any, times: Any) -> tuple[AxisRuns, None]:
        return AxisRuns(values, np.zeros(2), values, values + 1.0), None

    monkeypatch.setattr(gmfbo, "axis_runs", before)
    with pytest.raises(RuntimeError):
        UncorrectedGmfbo().propose(None, None)  # type: ignore[arg-type]
    np.testing.assert_array_equal(seen[0].measured, values)
    assert gmfbo.__dict__["axis_runs"] is before


def test_other_noise_scales_that_of_the_plant_alone() -> None:
    plain, loud = (
        Conditions(rng=np.random.default_rng(1), level=level).noise(0.2, 50) for level in (1.0, 3.0)
    )
    np.testing.assert_allclose(loud, 3.0 * plain)
    drive = PLANTS["drive_twin"]
    stated, scaled = (one.study().file.is1.noise for one in (drive, noisier(0.3)(drive)))
    assert scaled == pytest.approx({name: 0.3 * std for name, std in stated.items()})


def test_all_parts_name_methods_that_can_be_made() -> None:
    from gmfbo.tuning.methods import METHODS

    for part in PARTS.values():
        assert set(part.methods) <= {*RIVALS, *METHODS}
        assert set(part.plants) <= set(PLANTS)


def test_ax_finds_a_minimum() -> None:
    pytest.importorskip("ax", reason="the rival Ax is in no extra: pip install ax-platform")
    method, points = AxDefault(1), [np.array([0.2, 0.8]), np.array([0.9, 0.1])]
    for _ in range(12):
        asked = method.propose(of_runs(points), np.random.default_rng(0))
        points.append(asked.point)
    assert bowl(method.recommend(of_runs(points))[0]) < 0.05
