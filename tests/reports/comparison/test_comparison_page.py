"""The page of a comparison: its numbers are those of the folder, and a browser can use it."""

from __future__ import annotations

import json
import re
import shutil
import statistics
from pathlib import Path
from typing import Any

import pytest

from gmfbo.reports.comparison.page import comparison_page
from gmfbo.studies.comparison_review import review_comparison
from tests.pages.headless_browser import NO_BROWSER, Browser, browser_path
from tests.pages.page_text import PageText, at_path, rounds_to
from tests.reports.comparison.example_comparison import ARRIVALS, write_example_comparison

NEVER = 6


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_example_comparison(tmp_path_factory.mktemp("comparisons"))


@pytest.fixture(scope="module")
def page(folder: Path) -> str:
    return comparison_page(review_comparison(folder))


@pytest.fixture(scope="module")
def content(page: str) -> Any:
    return json.loads(PageText(page).embedded["comparison"])


@pytest.fixture
def browser(tmp_path: Path) -> Browser:
    path = browser_path()
    if path is None:
        pytest.skip(NO_BROWSER)
    return Browser(path, tmp_path)


def test_every_seed_is_that_of_the_folder(folder: Path, content: Any) -> None:
    paths = (folder / "runs").glob("*.jsonl")
    kept = [json.loads(line) for path in paths for line in path.read_text().splitlines()]
    assert len(content["runs"]) == len(kept) == 9
    for run in content["runs"]:
        (own,) = [k for k in kept if (k["method"], k["seed"]) == (run["method"], run["seed"])]
        for name in ("n_star", "best", "regret", "twin_runs", "corrected_runs"):
            assert run[name] == own[name], name
        assert run["cost"] == own["cost"][-1]
        assert run["seconds"] == pytest.approx(own["seconds_before"] + sum(own["seconds"]))


def test_summaries_are_those_of_the_seeds(content: Any) -> None:
    for one in content["methods"]:
        counted = [NEVER if n is None else n for n in ARRIVALS[one["method"]]]
        assert one["median"]["value"] == statistics.median(counted)
        assert one["mean"]["value"] == pytest.approx(statistics.mean(counted))
        assert one["mean"]["low"] <= one["mean"]["value"] <= one["mean"]["high"]
        assert one["never"] == pytest.approx(counted.count(NEVER) / 3)
        left = [run["regret"][-1] for run in content["runs"] if run["method"] == one["method"]]
        assert one["regret"] == pytest.approx(statistics.mean(left))


def test_curves_are_those_of_the_table(folder: Path, content: Any) -> None:
    rows = [line.split() for line in (folder / "curves.txt").read_text().splitlines()[1:]]
    told = [
        [curve["method"], curve["name"], x, *values]
        for curve in content["curves"]
        for x, *values in zip(*(curve[k] for k in ("x", "mean", "low", "high")), strict=True)
    ]
    assert len(told) == len(rows)
    for line, row in zip(told, rows, strict=True):
        assert line[:2] == row[:2]
        assert line[2:] == [float(text) for text in row[2:6]]


def test_every_marked_number_is_that_of_the_json(page: str, content: Any) -> None:
    numbers = PageText(page).numbers
    assert len(numbers) > 40
    for number in numbers:
        assert rounds_to(number, at_path(content, number.path)), number
    shown = {number.path for number in numbers}
    assert {f"runs.{k}.n_star" for k in range(9)} <= shown


def test_headline_names_the_method_with_the_fewest_real_runs(page: str) -> None:
    headline = re.search(r"<h1[^>]*>(.*?)</h1>", page)
    assert headline is not None
    words = re.sub(r"<[^>]+>", "", headline[1])
    assert words.startswith("gmfbo needs the fewest real runs: 3 [2, 4] on average, bo_ei 5 [")


def test_landscape_is_drawn_only_where_there_is_one(page: str, tmp_path: Path) -> None:
    assert page.count('class="chart map"') == 2
    without = review_comparison(write_example_comparison(tmp_path, landscape=None))
    assert 'class="chart map"' not in comparison_page(without)


def test_without_its_runs_the_curves_are_shown(folder: Path, tmp_path: Path) -> None:
    bare = tmp_path / "bare.compare"
    shutil.copytree(folder, bare)
    shutil.rmtree(bare / "runs")
    read = PageText(comparison_page(review_comparison(bare)))
    assert any("Its runs were not kept" in text for text in read.text)
    assert ("class", "first alone") in read.attributes


def test_a_method_is_hidden_and_shown_by_its_button(browser: Browser, page: str) -> None:
    question = """const all = (name) => [...document.querySelectorAll(name)];
      const seen = () => [all(".area .m1").filter((one) => !one.style.display).length,
        all("figure[data-method]").filter((one) => one.offsetHeight).length];
      const button = document.querySelector(".methods button[data-method=bo_ei]");
      const told = [seen()];
      button.click(); told.push(seen(), button.getAttribute("aria-pressed"));
      button.click(); told.push(seen());
      return [told, document.documentElement.scrollWidth <= innerWidth]"""
    answer = browser.ask(page, question, 500, 900)
    assert answer["complaints"] == []
    assert answer["loaded"] == []
    # A mean and a band in three charts, three seeds and their mean.
    assert answer["told"] == [[[10, 3], [0, 2], "false", [10, 3]], True]


def test_curves_are_read_by_keys_and_pointer(browser: Browser, page: str, content: Any) -> None:
    question = """const figure = document.querySelector("figure[data-curve=regret]");
      const read = () => figure.querySelector(".read-out").textContent;
      const key = (name) => figure.dispatchEvent(
        new KeyboardEvent("keydown", {key: name, bubbles: true, cancelable: true}));
      key("ArrowRight"); key("ArrowRight"); const told = [read()];
      document.querySelector(".methods button[data-method=random]").click();
      const at = figure.querySelector(".plot").getBoundingClientRect();
      figure.querySelector(".plot").dispatchEvent(new PointerEvent("pointermove",
        {clientX: at.right - 2, clientY: at.top + 9, bubbles: true}));
      told.push(read());
      return told"""
    answer = browser.ask(page, question, 1280, 800)
    assert answer["complaints"] == []
    curves = {one["method"]: one for one in content["curves"] if one["name"] == "regret"}

    def words(row: int, *methods: str) -> str:
        told = [
            f"{name} {curves[name]['mean'][row]:.3g} [{curves[name]['low'][row]:.3g}, "
            f"{curves[name]['high'][row]:.3g}]"
            for name in methods
        ]
        return f"real run {row + 1}: " + ", ".join(told)

    assert answer["told"] == [words(1, "gmfbo", "bo_ei", "random"), words(4, "gmfbo", "bo_ei")]


def test_headline_curves_and_table_are_on_the_first_screen(browser: Browser, page: str) -> None:
    question = """return [box("h1"), box(".first .chart"), box("table.errors")]"""
    for left, top, right, bottom in browser.ask(page, question, 1280, 800)["told"]:
        assert 0.0 <= left < right <= 1280
        assert 0.0 <= top < bottom <= 800
