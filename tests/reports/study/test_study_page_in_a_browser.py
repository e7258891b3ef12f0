"""The page of a study as a person meets it, in a real browser that has no network."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from tests.pages.headless_browser import NO_BROWSER, Browser, browser_path
from tests.reports.study.example_studies import write_example_study

pytestmark = pytest.mark.skipif(browser_path() is None, reason=NO_BROWSER)

WIDE, HIGH = 1280, 800
EVIL = "<b>\\\"&'</b><script>alert(1)</script>"


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> StudyReview:
    return StudyReview.read(write_example_study(tmp_path_factory.mktemp("studies")))


@pytest.fixture
def browser(tmp_path: Path) -> Browser:
    path = browser_path()
    assert path is not None
    return Browser(path, tmp_path)


CHOOSE = """
const told = () => document.querySelector("#told").textContent;
const list = document.querySelector("#viewer select");
const plot = document.querySelector("#viewer .plot");
plot.setPointerCapture = () => {};
const readAt = (share) => {
  const at = plot.getBoundingClientRect();
  plot.dispatchEvent(new PointerEvent("pointermove", {pointerId: 1, bubbles: true,
    clientX: at.left + share * at.width, clientY: at.top + 20}));
  return document.querySelector("#viewer .read-out").textContent;
};
const click = (element) => element.dispatchEvent(new MouseEvent("click", {bubbles: true}));
const lines = () => [...document.querySelectorAll("#viewer .area .line")]
  .map((line) => line.getAttribute("class"));
"""


def test_best_gains_curves_and_table_are_on_the_first_screen(
    browser: Browser, review: StudyReview
) -> None:
    question = """return {verdict: box("h1"), curves: box("#responses .chart"),
      table: box("table.errors"), wide: innerWidth, text: document.querySelector("h1").textContent,
      scrolled: document.documentElement.scrollWidth}"""
    answer = browser.ask(study_page(review), question, WIDE, HIGH)
    told = answer["told"]
    assert answer["complaints"] == []
    assert answer["loaded"] == []
    for name in ("verdict", "curves", "table"):
        left, top, right, bottom = told[name]
        assert 0.0 <= left < right <= WIDE, name
        assert 0.0 <= top < bottom <= HIGH, name
    assert told["table"][0] > told["curves"][2]
    assert told["scrolled"] <= WIDE
    assert review.best is not None
    for name, value in review.best.gains.items():
        assert f"{name} = {value:.4g}" in told["text"]


def test_every_run_is_shown_by_a_click_with_its_own_numbers(
    browser: Browser, review: StudyReview
) -> None:
    question = (
        CHOOSE
        + """const found = {};
      document.querySelectorAll("figure.gains .mark[data-run]").forEach((mark) => {
        click(mark);
        found[mark.dataset.run] = [told(), list.value, readAt(0.4)];
      });
      return found"""
    )
    answer = browser.ask(study_page(review), question, WIDE, HIGH)
    assert answer["complaints"] == []
    assert len(answer["told"]) == len(review.runs)
    for run in review.runs:
        words, chosen, read = answer["told"][str(run.trial.number)]
        assert chosen == str(run.trial.number)
        assert words.startswith(f"Run {run.trial.number} ")
        numbers = [*run.trial.gains.values(), run.trial.objective, *run.trial.metrics.values()]
        said = [float(text) for text in re.findall(r"(?<![\w.])-?\d[\d.e-]*(?![\w])", words)]
        for value in numbers:
            assert any(abs(one - value) <= 5e-4 * abs(value) + 1e-12 for one in said), (
                words,
                value,
            )
        own = run.trial
        time = float(read.split(" s: ")[0])
        row = int(np.searchsorted(own.recording.time, time - 1e-9))
        position = own.recording.signal("position")[row]
        assert any(
            abs(float(text) - position) <= 1e-3 * abs(position) + 1e-9
            for text in re.findall(r"-?\d[\d.e-]*(?=,| rad)", read)
        ), (read, position)


def test_a_run_is_shown_with_twin_and_corrected_twin(browser: Browser, review: StudyReview) -> None:
    real = review.real[2].trial.number
    question = (
        CHOOSE
        + f"""const shown = {{}};
      [{real}, {real + 1}, {real + 2}, 1].forEach((number) => {{
        list.value = number; list.dispatchEvent(new Event("change"));
        shown[number - {real}] = lines();
      }});
      const bands = document.querySelectorAll("#viewer .band").length;
      list.value = {real + 2}; list.dispatchEvent(new Event("change"));
      return [shown, bands, document.querySelectorAll("#viewer .band").length]"""
    )
    shown, none, band = browser.ask(study_page(review), question, WIDE, HIGH)["told"]
    context = ["line floor", "line recorded", "line before"]
    assert shown["0"] == [*context, "line after thin"]
    assert shown["1"] == [*context, "line after thin"]
    assert shown["2"] == [*context, "line after"]
    assert shown[str(1 - real)] == ["line floor", "line before"]
    assert (none, band) == (0, 1)


def test_keys_and_buttons_step_through_the_runs(browser: Browser, review: StudyReview) -> None:
    question = (
        CHOOSE
        + """const viewer = document.querySelector("#viewer"), found = [];
      const key = (name) => viewer.dispatchEvent(
        new KeyboardEvent("keydown", {key: name, bubbles: true, cancelable: true}));
      list.value = 10; list.dispatchEvent(new Event("change"));
      key("ArrowRight"); found.push(list.value); key("ArrowLeft"); key("ArrowLeft");
      found.push(list.value);
      click(document.querySelector("[aria-label='next run']")); found.push(list.value);
      click(document.querySelector("[aria-label='signal torque command']"));
      found.push(document.querySelector("#viewer .y-label").textContent);
      click(document.querySelector("table.runs button[data-run='9']"));
      found.push(told().slice(0, 6));
      found.push(document.querySelectorAll(".mark.shown").length);
      const focusable = [...document.querySelectorAll("button, select, a, [tabindex]")];
      found.push(focusable.every((one) => one.tabIndex === 0),
        [...document.querySelectorAll("svg.plot, select, button")].every((one) =>
          one.getAttribute("aria-label") || one.textContent));
      return found"""
    )
    answer = browser.ask(study_page(review), question, WIDE, HIGH)
    assert answer["complaints"] == []
    # The last choice stands on the map, in the two charts of the descent, among the sources, and
    # in the six pairs of metrics.
    expected = ["11", "9", "10", "torque command [N\u00a0m]", "Run 9 ", 10, True, True]
    assert answer["told"] == expected


@pytest.mark.parametrize("wide", [500, 800, 1280])
def test_no_screen_is_scrolled_sideways(browser: Browser, review: StudyReview, wide: int) -> None:
    question = "return [document.documentElement.scrollWidth, innerWidth]"
    scrolled, screen = browser.ask(study_page(review), question, wide, 900)["told"]
    assert screen == wide
    assert scrolled <= screen


def test_names_from_outside_are_text(browser: Browser, tmp_path: Path) -> None:
    made = StudyReview.read(write_example_study(tmp_path))
    evil = replace(made, file=made.file.model_copy(update={"name": EVIL, "method": EVIL}))
    question = 'return [document.querySelector(".top").textContent, document.scripts.length]'
    answer = browser.ask(study_page(evil), question, WIDE, HIGH)
    assert answer["complaints"] == []
    assert EVIL in answer["told"][0]
    assert answer["told"][1] == 5  # the page's two texts of JSON, its script, and the test's two


def test_dark_and_light_are_different_pictures(browser: Browser, review: StudyReview) -> None:
    page = study_page(review)
    dark = browser.picture(page, WIDE, HIGH, "--blink-settings=preferredColorScheme=0")
    light = browser.picture(page, WIDE, HIGH)
    assert dark != light
    assert len(light) > 20_000


def test_without_its_script_the_page_shows_first_and_best_and_all_numbers(
    browser: Browser, review: StudyReview
) -> None:
    page = re.sub(r"<script>.*?</script>", "", study_page(review), flags=re.DOTALL)
    question = """return [document.querySelectorAll("#responses .area .line").length,
      document.querySelectorAll("table.runs tbody tr").length, box("figure.gains")]"""
    answer = browser.ask(page, question, WIDE, HIGH)
    assert answer["complaints"] == []
    assert answer["told"][0] == 3
    assert answer["told"][1] == len(review.real) + len(review.runs)
