"""Tables against numbers worked out by hand."""

from __future__ import annotations

import pytest

from gmfbo.studies.comparison_folder import by_method
from gmfbo.studies.comparison_table import Table
from tests.studies.small_study import outcome


def cells(text: str, label: str, part: int = 0) -> list[str]:
    """Entries of the n-th row with a label."""
    rows = [line.split()[1:] for line in text.splitlines() if line.split()[:1] == [label]]
    return rows[part]


OUTCOMES = [
    outcome("random", 0, None),
    outcome("bo_ei", 0, 3, n_star_paper=3),
    outcome("random", 1, 4, n_star_paper=4),
    outcome("bo_ei", 1, 5),
    outcome("bo_ei", 2, 2, n_star_paper=2),
]


@pytest.fixture(scope="module")
def text() -> str:
    return Table(by_method(OUTCOMES)).text()


def test_every_seed_is_shown_and_a_miss_counts_one_more_than_the_budget(text: str) -> None:
    below = text.split("n* of each seed")[1]
    assert cells(below, "seed") == ["0", "1", "2"]
    assert cells(below, "bo_ei") == ["3", "5", "2"]
    assert cells(below, "random") == ["6", "4", "-"]


def test_more_seeds_than_a_line_holds_go_on_below() -> None:
    many = Table(by_method([outcome("random", seed, 2 + seed % 3) for seed in range(30)])).text()
    below = many.split("n* of each seed")[1]
    assert cells(below, "seed", 1) == ["25", "26", "27", "28", "29"]
    assert cells(below, "random", 1) == ["3", "4", "2", "3", "4"]
    assert cells(many, "random")[-1] == "30"


def test_median_mean_and_share_that_never_arrived(text: str) -> None:
    bo_ei, random = cells(text, "bo_ei"), cells(text, "random")
    assert (bo_ei[0], random[0]) == ("3.0", "5.0")
    assert (bo_ei[3], random[3]) == ("3.33", "5.00")
    assert bo_ei[6:] == ["5", "0", "%", "3"]
    assert random[6:] == ["6", "50", "%", "2"]


def test_second_table_counts_as_the_publication_does(text: str) -> None:
    below = text.split("the same within")[1]
    assert cells(below, "bo_ei")[6:] == ["6", "33", "%", "3"]
    assert cells(below, "random")[6:] == ["6", "50", "%", "2"]


def test_differences_are_taken_on_shared_seeds_alone(text: str) -> None:
    below = text.split("less that of bo_ei")[1]
    # Seeds 0 and 1: 6 - 3 and 4 - 5.
    row = cells(below, "random")
    assert row[0] == "1.00"
    assert row[-4:] == ["1", "0", "1", "2"]


def test_methods_without_a_common_seed_are_said_to_have_none() -> None:
    table = Table(by_method([outcome("bo_ei", 0, 3), outcome("random", 1, 4)]))
    assert "no seed in common" in table.text()


def test_order_in_which_runs_finished_does_not_show() -> None:
    turned = Table(by_method(OUTCOMES[::-1])).text()
    assert turned == Table(by_method(OUTCOMES)).text()


def test_changes_that_were_noticed_are_counted_where_the_runs_know_them(text: str) -> None:
    assert "noticed" not in text
    known = [outcome("bo_ei", seed, 3, alarms=at) for seed, at in enumerate([(), (6, 9), (8,)])]
    below = Table(by_method([*known, *OUTCOMES])).text().split("that were noticed")[1]
    assert cells(below, "bo_ei") == ["2", "3", "7.0", "3"]
    assert "random" not in below.split("n* of each seed")[0]
