"""The probability of a name falls with what else could have made the recordings."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pytest

from gmfbo.diagnosis.naming.decision import Round
from gmfbo.diagnosis.naming.probability import probability
from tests.diagnosis.naming.linear_evidences import (
    ROWS,
    WINDOWS,
    Array,
    Fits,
    between,
    direction,
    fits_of,
)

NEEDED = 30.0
MARGIN = 15.0
WINNER = "coulomb_friction"
OWN = direction(11)
"""What the winner changes."""

UNLIKE = {
    name: [direction(20 + i)]
    for i, name in enumerate(
        ("transport_delay", "cogging_torque", "backlash", "sensor_lag", "gravity_torque")
    )
}


def recorded(truth: Array, seed: int = 3) -> Array:
    noise: Array = np.random.default_rng(seed).standard_normal(WINDOWS * ROWS)
    return truth + noise


def trusted(fits: Fits, rivals: Collection[str] = (), dispersion: float = 1.0) -> float:
    """Probability of the winner among these fits."""
    winner = fits.of(WINNER)
    found = Round(winner, tuple(fits.of(n) for n in rivals), tuple(fits.effects), NEEDED, MARGIN)
    return probability(fits.base, found, dispersion, np.random.default_rng(0))


def test_a_clear_winner_with_nothing_beside_it_is_trusted_to_95_in_100() -> None:
    assert trusted(fits_of(recorded(30.0 * OWN), {WINNER: [OWN]})) == 0.95


def test_a_clear_winner_beside_effects_that_look_otherwise_is_trusted() -> None:
    fits = fits_of(recorded(30.0 * OWN), {WINNER: [OWN], **UNLIKE})
    assert fits.effects[0].name == WINNER
    assert trusted(fits) > 0.9


def test_a_winner_is_trusted_less_the_more_another_effect_looks_like_it() -> None:
    found = []
    for cosine in (0.0, 0.999, 0.99999):
        like = {WINNER: [OWN], "transport_delay": [between(OWN, direction(12), cosine)]}
        found.append(trusted(fits_of(recorded(30.0 * OWN), like)))
    assert found[0] > found[1] > found[2]
    # A twin of the winner takes half the prior of effects, and half of the draws.
    assert found[2] == pytest.approx(0.5, abs=0.1)


def test_an_effect_listed_as_a_rival_does_not_count_against_the_claim() -> None:
    like = {WINNER: [OWN], "transport_delay": [between(OWN, direction(12), 0.99999)]}
    assert trusted(fits_of(recorded(30.0 * OWN), like), ["transport_delay"]) == 0.95


def test_a_law_that_contains_the_winner_and_gains_no_more_changes_nothing() -> None:
    changes = {WINNER: [OWN], **UNLIKE}
    without = trusted(fits_of(recorded(30.0 * OWN), changes))
    containing = {**changes, "stribeck_friction": [OWN, direction(13)]}
    fits = fits_of(recorded(30.0 * OWN), containing)
    assert fits.of("stribeck_friction").gain > fits.of(WINNER).gain
    assert trusted(fits) == without


def test_a_winner_that_leaves_more_of_the_misfit_is_trusted_less() -> None:
    """What no effect explains may come from outside the library."""
    found = []
    for left in (0.0, 20.0, 60.0):
        truth = 20.0 * OWN + left * direction(14)
        found.append(trusted(fits_of(recorded(truth), {WINNER: [OWN], **UNLIKE})))
    assert found[0] > found[1] > found[2]
    assert found[2] < 0.5


def test_a_winner_that_hardly_exceeds_what_is_asked_for_is_named_in_fewer_replays() -> None:
    clear, faint = (
        trusted(fits_of(recorded(size * OWN), {WINNER: [OWN], **UNLIKE})) for size in (30.0, 5.0)
    )
    assert faint < clear


def test_the_same_source_of_noise_gives_the_same_probability() -> None:
    fits = fits_of(recorded(8.0 * OWN), {WINNER: [OWN], **UNLIKE})
    assert trusted(fits) == trusted(fits)
