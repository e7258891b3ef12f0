"""Where findings of several recordings are told as one, none of their numbers is hidden."""

from __future__ import annotations

import pytest

from gmfbo.diagnosis.checking.grouped_findings import grouped, told_together
from gmfbo.diagnosis.checking.result import Finding


def scaled(recording: str, times: str, cure: str = "correct its scale") -> Finding:
    return Finding("scaled_column", recording, "torque", f"is {times} times what it was", cure)


def test_the_smallest_and_the_largest_of_each_number_are_told() -> None:
    told = [
        f"{rows} of {of} rows repeat, by {by} %" for rows, of, by in ((9, 200, 4.5), (12, 200, 2))
    ]
    assert told_together(told) == "9 to 12 of 200 rows repeat, by 2 to 4.5 %"


@pytest.mark.parametrize(
    ("sentences", "together"),
    [
        (["is 1.2 times"], "is 1.2 times"),
        (["is 1.2 times"] * 3, "is 1.2 times"),
        (["is off by -0.2 N m", "is off by 1e-3 N m"], "is off by -0.2 to 1e-3 N m"),
        (["is 1.20 times", "is 1.2 times"], "is 1.20 times"),
        (["jump at 0.4, 1.2 s", "jump at 0.3 s"], "jump at 0.3 to 1.2 s"),
        (["jump at 1, 2, 3 ... s", "jump at 4 s"], "jump at 1 to 4 ... s"),
        (["p2.csv: 3 rows", "p2.csv: 7 rows"], "p2.csv: 3 to 7 rows"),
        (["nothing", "nothing"], "nothing"),
    ],
)
def test_one_sentence_stands_for_all(sentences: list[str], together: str) -> None:
    assert told_together(sentences) == together


def test_findings_are_one_group_where_only_numbers_differ() -> None:
    one, other = scaled("a.csv", "1.2"), scaled("b.csv", "3.0")
    fast = scaled("c.csv", "1.2", "run 2 faster")
    faster = scaled("d.csv", "1.2", "run 3 faster")
    assert grouped([one, fast, other, faster]) == [[one, other], [fast, faster]]


def test_a_digit_of_a_name_is_no_number() -> None:
    """Two gains, or two columns, are two findings."""
    assert len(grouped([scaled("a", "1", "set k1"), scaled("a", "1", "set k2")])) == 2
    assert len(grouped([scaled("a", "1", "map 1.csv"), scaled("a", "1", "map 2.csv")])) == 2
