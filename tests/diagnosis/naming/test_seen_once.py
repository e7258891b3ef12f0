"""What one stretch alone tells is believed less, and said with "may"."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gmfbo.diagnosis.naming.decision import Compared
from gmfbo.diagnosis.naming.stretch_evidence import seen_once


def compared() -> Compared:
    """Two recordings of four stretches of 10 rows."""
    segments = [SimpleNamespace(record=k, time=np.arange(40.0)) for k in range(2)]
    stretches = [[slice(i, i + 10) for i in range(0, 40, 10)] for _ in segments]
    problem = SimpleNamespace(segments=segments, stretches=lambda: stretches)
    return cast("Compared", SimpleNamespace(search=SimpleNamespace(problem=problem)))


@pytest.mark.parametrize(
    ("gains", "said"),
    [
        ([[0.0, 0.1, -0.2, 0.0], [0.3, 0.0, 500.0, 0.0]], "b.csv 20-29 s"),
        ([[0.0, 0.1, -0.2, 0.0], [-90.0, 0.0, 500.0, 0.0]], "b.csv 20-29 s"),
        ([[20.0, 30.0, 10.0, 0.0], [30.0, 0.0, 500.0, 0.0]], ""),
        ([[0.0, 0.0, 0.0, 0.0], [1.0, 300.0, 500.0, 40.0]], "b.csv 20-29 s"),
        ([[0.0, 0.0, 0.0, 0.0], [30.0, 0.0, 500.0, 0.0]], ""),
        ([[2.0, 3.0, 2.0, 2.0], [3.0, 2.0, 2.0, 1.0]], ""),
    ],
)
def test_only_a_law_that_other_stretches_show_is_seen_more_than_once(
    gains: list[list[float]], said: str
) -> None:
    names: Any = ["a.csv", "b.csv"]
    fallen = [np.array(own) for own in gains]
    assert seen_once(names, compared(), fallen, fallen) == said


def test_a_pulse_is_seen_once_whatever_parameters_had_made_of_it_elsewhere() -> None:
    """Without it the twin's parameters were bent, which left something in every stretch."""
    fallen = [np.full(4, 12.0), np.array([10.0, 300.0, 500.0, 9.0])]
    acts = [np.zeros(4), np.array([0.0, 350.0, 520.0, 0.1])]
    names: Any = ["a.csv", "b.csv"]
    assert seen_once(names, compared(), fallen, fallen) == ""
    assert seen_once(names, compared(), fallen, acts) == "b.csv 20-29 s"
