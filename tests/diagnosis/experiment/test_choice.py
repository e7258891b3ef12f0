"""The one choice of what to play, for variations of recordings and for motions within limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.experiment.choice import Choice, choose
from gmfbo.diagnosis.experiment.reference_menu import MenuEntry
from gmfbo.diagnosis.experiment.separation import Plays, Separation

ENTRIES = [MenuEntry(name, f"a {name}", np.zeros(1)) for name in ("ramp", "chirp", "hold")]
SIZES = {
    "backlash": (math.inf, 1.0, 4.0),
    "coulomb_friction": (1.0, 2.0, math.inf),
    "gravity_torque": (math.inf, math.inf, math.inf),
}


def size(name: str, plays: Plays) -> float:
    return min(SIZES[name][place] for place in plays)


def told(**odds: float) -> Choice:
    """A choice that separates pairs such as `ab` by these log odds."""
    pairs = {(pair[0], pair[1]): value for pair, value in odds.items()}
    return Choice((0, 0), "a ramp, played twice", separation=Separation((0, 0), pairs))


@pytest.mark.parametrize(
    ("effects", "motion"),
    [
        (["backlash"], "a ramp, then a chirp"),
        (["coulomb_friction"], "a ramp, played twice"),
        (["backlash", "coulomb_friction"], "a ramp, then a chirp"),
    ],
)
def test_without_rivals_the_effects_show_at_the_smallest_sizes(
    right_case: Case, effects: list[str], motion: str
) -> None:
    chosen = choose(right_case, ENTRIES, {}, effects, size)
    assert chosen is not None
    assert chosen.motion == motion
    assert chosen.names == tuple(effects)


def test_an_effect_that_nothing_shows_is_not_named(right_case: Case) -> None:
    chosen = choose(right_case, ENTRIES, {}, ["gravity_torque", "backlash"], size)
    assert chosen is not None
    assert chosen.names == ("backlash",)
    assert chosen.why == "excites what was not excited so far: backlash"


def test_an_empty_menu_gives_no_choice(right_case: Case) -> None:
    assert choose(right_case, [], {}, ["backlash"], size) is None


def test_it_says_which_rivals_it_tells_apart_and_which_not() -> None:
    assert told(ab=20.0).why == "tells a from b"
    assert told(ab=20.0, ac=30.0, bc=16.0).why == "tells a, b and c apart"
    some = told(ab=20.0, ac=30.0, bc=1.0)
    assert some.why == "tells a from b; a from c; it does not tell b from c"
    assert some.names == ("a", "b", "c")


def test_what_would_be_in_vain_names_no_rival_and_says_what_would_be_enough() -> None:
    vain = told(ab=2.0, ac=3.0, bc=1.0)
    assert vain.names == ()
    assert vain.why == (
        "tells no two apart, a from c most nearly: log odds of 3 nats are expected, 15 would be "
        "enough"
    )
