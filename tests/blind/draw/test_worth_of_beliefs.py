"""The line by which probabilities are told is found where it is known, and is that of the draw."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit

from gmfbo.diagnosis.comparison.numbers import WORTH
from tests.benchmarks.tables.results import RESULTS
from tests.blind.draw.measures import recalibration
from tests.blind.draw.outcomes import read_outcomes
from tests.blind.draw.worth import Stated, by_held_out, line_of, of_other_machines, stated_in

DRAW = RESULTS / "diagnosis_draw" / "registered_seed_311992_9dae4c83.jsonl"


def claims(line: tuple[float, float, float], count: int) -> list[Stated]:
    """Claims that are right as often as a line says."""
    rng = np.random.default_rng(2)
    belief, gain = rng.uniform(0.5, 0.99, count), np.exp(rng.uniform(1.0, 6.9, count))
    odds = line[0] + line[1] * np.log(belief / (1.0 - belief)) + line[2] * np.log(gain)
    right = rng.random(count) < expit(odds)
    return [
        Stated(float(b), float(g), bool(r), 0.0, f"machine {k % 4}", k)
        for k, (b, g, r) in enumerate(zip(belief, gain, right, strict=True))
    ]


def test_the_line_is_found_that_claims_were_drawn_from() -> None:
    drawn = claims((-1.0, 0.5, 0.3), 20_000)
    assert line_of(drawn) == pytest.approx([-1.0, 0.5, 0.3], abs=0.1)
    fitted = recalibration(of_other_machines(drawn), [one.right for one in drawn])
    assert fitted is not None
    assert fitted[0] == pytest.approx([0.0, 1.0], abs=0.1)


def test_the_line_in_force_is_that_of_the_registered_draw() -> None:
    stated = stated_in(list(read_outcomes(DRAW)))
    assert tuple(round(float(value), 2) for value in line_of(stated)) == WORTH


def test_names_are_counted_by_what_held_out_recordings_say() -> None:
    one = Stated(0.99, 100.0, True, 0.0, "axis", 1)
    wrong, unseen = replace(one, right=False), replace(one, is_borne_out=False)
    told = by_held_out([one, one, wrong, unseen, replace(wrong, is_physics=False)])
    assert [line.split(": ")[-1] for line in told[-2:]] == ["2 of 3 right", "1 of 1 right"]
