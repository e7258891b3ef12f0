"""Which share of a signal a law makes: closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.diagnosis.validating.resembled_law import share_made

TIME = np.arange(4000) / 1000.0
SPEED = np.sin(2.0 * np.pi * 3.0 * TIME)
PLAIN = np.stack([np.ones(TIME.size), SPEED])
SIGN = np.sign(SPEED)


def test_a_law_makes_all_of_its_own_signal_beside_what_parameters_make() -> None:
    assert share_made(7.0 * SIGN - 3.0 * SPEED + 2.0, SIGN, PLAIN) == pytest.approx(1.0)


def test_a_law_of_the_other_sign_makes_nothing() -> None:
    assert share_made(-7.0 * SIGN, SIGN, PLAIN) == 0.0


def test_what_parameters_make_is_like_no_law() -> None:
    assert share_made(SPEED, SIGN, PLAIN) == pytest.approx(0.0, abs=1e-9)
    assert share_made(SIGN, SPEED, PLAIN) == 0.0


def test_of_a_sum_of_two_signals_alike_in_nothing_each_makes_its_square() -> None:
    other = np.cos(2.0 * np.pi * 40.0 * TIME)
    made = share_made(2.0 * other + np.cos(2.0 * np.pi * 80.0 * TIME), other, PLAIN)
    assert made == pytest.approx(0.8, abs=1e-6)
