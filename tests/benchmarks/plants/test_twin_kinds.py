"""Twins of the kinds answer as their names say."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.recordings.recording import Trajectory
from tests.benchmarks.plants.catalogue import PLANTS
from tests.benchmarks.plants.judge import Judge
from tests.benchmarks.plants.twin_kinds import of_kind, other_gains

PLANT = PLANTS["linear_axis"]


def answer(kind: str, unit: tuple[float, float]) -> Trajectory:
    """What the twin of a kind answers at gains in the unit cube."""
    with other_gains(PLANT, kind), Judge.open(of_kind(PLANT, kind)) as judge:
        named = judge.gains.values(judge.gains.space.from_unit(np.array(unit)))
        run = judge.sources.is2.run(named, judge.experiment.reference)
        assert isinstance(run, Trajectory)
        assert {name: run.parameters[name] for name in named} == pytest.approx(named)
        return run


def test_a_useless_twin_does_not_depend_on_the_gains() -> None:
    first, second = answer("useless", (0.2, 0.3)), answer("useless", (0.9, 0.6))
    np.testing.assert_array_equal(first.signals["position"], second.signals["position"])


def test_an_opposed_twin_answers_as_at_mirrored_gains() -> None:
    mirrored = answer("", (0.8, 0.3))
    opposed = answer("opposed", (0.2, 0.7))
    np.testing.assert_allclose(opposed.signals["position"], mirrored.signals["position"])


def test_a_perfect_twin_is_its_plant() -> None:
    with Judge.open(of_kind(PLANT, "perfect")) as judge:
        point = judge.gains.space.from_unit(np.array([0.4, 0.5]))
        played = judge.run(point)
    twin = answer("", (0.4, 0.5))
    np.testing.assert_allclose(played.signals["position"], twin.signals["position"])


def test_a_far_off_twin_excludes_the_truth() -> None:
    with Judge.open(of_kind(PLANT, "far_off")) as judge:
        assert judge.sources.is2.nominal("mass") == 3.0 * 120.0  # type: ignore[attr-defined]
