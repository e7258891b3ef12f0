"""Noise that is played meets the laws, and no parameter can be fitted to it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.heard_noise import HeardNoise
from gmfbo.diagnosis.comparison.hearing.sensed_noise import sensed_noise
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.runs.simulated import Simulated
from tests.diagnosis.noise.planted_noise import opened, planted

Array = NDArray[np.float64]
SIGMA = 3e-4  # [rad]


@pytest.fixture(scope="module")
def played() -> Iterator[tuple[Problem, HeardNoise]]:
    with opened(planted(SIGMA)) as case:
        search = (stated := comparison_of(case, [])).search
        ledger = search.opened(stated.first)
        base = ledger.rows[frozenset()]
        noise = sensed_noise(search.problem, base, ledger.kernels, ledger.levels)
        yield search.problem, HeardNoise(noise, base.hypothesis, base.parameters)


def simulated(
    played: tuple[Problem, HeardNoise], hypothesis: Hypothesis, **parameters: float
) -> tuple[list[Simulated], list[Simulated]]:
    """Without noise, and with what it makes."""
    problem, heard = played
    at = hypothesis.start({**heard.parameters, **parameters})
    (quiet,) = problem.simulations.run([problem.point(hypothesis, at)])
    noisy = heard.beside(problem, hypothesis, (), quiet)
    return quiet, noisy


def change(runs: tuple[list[Simulated], list[Simulated]]) -> Array:
    quiet, noisy = runs
    return np.concatenate(
        [
            b - a
            for one, two in zip(quiet, noisy, strict=True)
            for a, b in zip(one.signals, two.signals, strict=True)
        ]
    )


def with_friction(played: tuple[Problem, HeardNoise], level: float) -> Hypothesis:
    return Hypothesis(played[1].about.setting, (Candidate("coulomb_friction", {"level": level}),))


def test_about_its_point_a_law_is_simulated_under_the_noise(
    played: tuple[Problem, HeardNoise],
) -> None:
    problem, heard = played
    hypothesis = with_friction(played, 0.1)
    _, noisy = simulated(played, hypothesis)
    (exact,) = problem.simulations.run([heard.points(problem, hypothesis)[0]])
    for one, two in zip(noisy, exact, strict=True):
        for own, other in zip(one.signals, two.signals, strict=True):
            np.testing.assert_allclose(own, other, atol=1e-12)


def test_noise_makes_more_of_friction_than_of_an_axis_without(
    played: tuple[Problem, HeardNoise],
) -> None:
    plain = change(simulated(played, played[1].about))
    rubbing = change(simulated(played, with_friction(played, 0.1)))
    assert np.std(rubbing) > 3.0 * np.std(plain)


def test_no_parameter_changes_what_noise_makes(played: tuple[Problem, HeardNoise]) -> None:
    hypothesis = with_friction(played, 0.1)
    inertia = played[1].parameters["inertia"]
    as_told = change(simulated(played, hypothesis))
    heavier = change(simulated(played, hypothesis, inertia=1.3 * inertia))
    np.testing.assert_allclose(heavier, as_told, atol=1e-12)


def test_a_gap_and_a_shaft_do_not_share_one_load_while_noise_is_played(
    played: tuple[Problem, HeardNoise],
) -> None:
    problem, heard = played
    whole = heard.parameters["inertia"]
    shaft = Candidate(
        "torsional_compliance",
        {"stiffness": 100.0, "damping": 0.01, "load_inertia": 0.5 * whole},
    )
    gap = Candidate("backlash", {"gap": 1e-3, "load_inertia": 0.5 * whole})
    about = replace(heard, about=replace(heard.about, effects=(shaft,)))
    noisy, quiet = about.points(problem, Hypothesis(heard.about.setting, (gap,)))
    for point in (noisy, quiet):
        assert not any(name.startswith("torsional") for name in point.physics)
        assert point.parameters["inertia"] == pytest.approx(0.5 * whole)
