""" "100 % removed" stands only where nothing is left that follows the reference."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest

from gmfbo.cli.diagnosis.diagnosis_screen import screenful
from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.diagnosis.result.explained import Remainder
from gmfbo.diagnosis.result.reference_test import ResidualTest
from gmfbo.diagnosis.result.removed_error import STILL_FOLLOWS, removed_percent, rounded_down
from tests.diagnosis.example_diagnoses import FIT, friction
from tests.pages.page_text import PageText, rounds_to

PASSES = ResidualTest("rec3.csv", "position", 0.0188, 0.00031, 0.00042, 0.0003)
FOLLOWS = ResidualTest("rec3.csv", "torque_command", 0.2911, 0.0212, 0.0104, 0.0041)
IN_TOLERANCE = replace(FOLLOWS, tolerance=0.05)
UNKNOWN = replace(PASSES, bound=float("nan"))


def made(share: float, *tests: ResidualTest) -> Diagnosis:
    return replace(
        friction(), fit=replace(FIT, explainable_error_removed=share), residual_tests=tests
    )


def shown(diagnosis: Diagnosis) -> list[str]:
    """Terminal, sentence and page, as text."""
    page = re.sub(
        r"<script.*?</script>|<style.*?</style>", "", diagnosis_page(diagnosis), flags=re.S
    )
    page = re.sub(r"<[^>]+>", "", page).replace("\xa0", " ")
    return ["\n".join(screenful(diagnosis)), diagnosis.sentence, page]


@pytest.mark.parametrize("share", [0.995, 0.9962, 0.99999, 1.0])
def test_all_is_removed_where_every_residual_passes(share: float) -> None:
    terminal, sentence, page = shown(made(share, PASSES))
    assert "removed      100 % of the error that physics can explain" in terminal
    assert "100 % of the error that physics can explain is removed" in page
    assert all(STILL_FOLLOWS not in text for text in (terminal, sentence, page))


@pytest.mark.parametrize(
    ("share", "said"), [(0.995, "99.5 %"), (0.9968, "99.6 %"), (0.99999, "99.9 %"), (1.0, "99.9 %")]
)
@pytest.mark.parametrize("tests", [(FOLLOWS,), (PASSES, IN_TOLERANCE)])
def test_a_share_is_rounded_down_where_one_residual_follows(
    share: float, said: str, tests: tuple[ResidualTest, ...]
) -> None:
    terminal, sentence, page = (" ".join(text.split()) for text in shown(made(share, *tests)))
    told = f"{said} of the error that physics can explain"
    assert f"removed {told}; {STILL_FOLLOWS}" in terminal
    assert f"{told} is removed; {STILL_FOLLOWS}" in page
    assert sentence.endswith(f"; {STILL_FOLLOWS}.")
    assert all("100 %" not in text for text in (terminal, sentence))


@pytest.mark.parametrize("tests", [(), (UNKNOWN,)])
def test_where_nothing_was_tested_neither_is_claimed(tests: tuple[ResidualTest, ...]) -> None:
    assert removed_percent(made(0.9999, *tests)) == "99.9 %"
    assert STILL_FOLLOWS not in made(0.9999, *tests).sentence


@pytest.mark.parametrize(("share", "said"), [(0.98, "98 %"), (0.9949, "99 %"), (0.0031, "0.31 %")])
def test_a_share_that_does_not_round_to_all_is_told_as_ever(share: float, said: str) -> None:
    assert rounded_down(share) == said
    assert removed_percent(made(share, FOLLOWS)) == said


@pytest.mark.parametrize("share", [0.9959, 0.99999, 1.0, 0.0031])
def test_the_number_on_the_page_stays_that_of_the_json(share: float) -> None:
    numbers = PageText(diagnosis_page(made(share, FOLLOWS))).numbers
    (found,) = [one for one in numbers if one.path == "fit.explainable_error_removed"]
    assert rounds_to(found, share)


@pytest.mark.parametrize(
    ("share", "said"),
    [(1.3, "100 %"), (2.99, "100 %"), (1.0, "100 %"), (0.996, "100 %"), (0.23, "23 %")],
)
def test_what_is_left_is_one_number_and_at_most_all_of_it(share: float, said: str) -> None:
    made = replace(friction(), remainder=Remainder(share, None, None, "throughout"))
    told = f"{said} of what is more than noise is explained by no law"
    terminal, sentence, page = (" ".join(text.split()) for text in shown(made))
    assert f"left {told}" in terminal
    assert f" {told}." in sentence
    assert told in page
    assert not re.search(rf"%\s*{told}", page)
    numbers = PageText(diagnosis_page(made)).numbers
    (found,) = [one for one in numbers if one.path == "remainder.share"]
    assert rounds_to(found, json.loads(made.to_json())["remainder"]["share"])


def test_a_small_share_is_told_where_it_is_known_on_what_it_depends() -> None:
    """A chirp leaves so much that what no law explains elsewhere is next to nothing of it."""
    made = replace(friction(), remainder=Remainder(0.0007, "torque", "velocity", "throughout"))
    told = "less than 1 % of what is more than noise is explained by no law"
    terminal, sentence, _ = (" ".join(text.split()) for text in shown(made))
    assert f"left {told}" in terminal
    assert f"L{told[1:]}; it depends on the velocity." in sentence
