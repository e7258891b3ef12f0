"""The report page as a person meets it, in a real browser that has no network."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.page.page import diagnosis_page
from tests.diagnosis.example_diagnoses import (
    friction,
    nothing,
    outside,
    parameters,
    rivals,
    too_little,
    with_law,
)
from tests.pages.headless_browser import NO_BROWSER, Browser, browser_path

pytestmark = pytest.mark.skipif(browser_path() is None, reason=NO_BROWSER)

ALL = [friction(), rivals(), nothing(), parameters(), outside(), too_little()]
WIDE, HIGH = 1280, 800
TWO_RECORDINGS = replace(
    friction(),
    curves=(
        *friction().curves,
        *(replace(curve, recording="rec2.csv") for curve in friction().curves),
    ),
)


@pytest.fixture
def browser(tmp_path: Path) -> Browser:
    path = browser_path()
    assert path is not None
    return Browser(path, tmp_path)


@pytest.mark.parametrize("made", ALL, ids=lambda made: f"{made.verdict}-{len(made.effects)}")
def test_verdict_curves_and_errors_are_on_the_first_screen(
    browser: Browser, made: Diagnosis
) -> None:
    question = """return {verdict: box("h1"), signal: box(".panel .chart"),
      error: box(".panel .chart.low"), table: box("table.errors"), wide: innerWidth,
      lines: [...document.querySelectorAll(".panel:not([hidden]) .area .line")]
        .map((line) => line.getBoundingClientRect().width)}"""
    answer = browser.ask(diagnosis_page(made), question, WIDE, HIGH)
    told = answer["told"]
    assert answer["complaints"] == []
    assert answer["loaded"] == []
    assert told["wide"] == WIDE
    for name in ("verdict", "signal", "error", "table"):
        left, top, right, bottom = told[name]
        assert 0.0 <= left < right <= WIDE, name
        assert 0.0 <= top < bottom <= HIGH, name
    assert told["table"][0] > told["signal"][2]  # beside the curves, not upon them
    assert told["error"][1] >= told["signal"][3] - 1.0
    assert len(told["lines"]) >= 4
    assert min(told["lines"]) > 500.0


def test_a_complaint_of_the_page_is_heard(browser: Browser) -> None:
    """Negative control: what the tests above take as silence is not deafness."""
    page = diagnosis_page(nothing()).replace("</body>", "<script>gone()</script></body>")
    page = page.replace("</body>", '<img src="http://example.com/missing.png"></body>')
    answer = browser.ask(page, "return 1", WIDE, HIGH)
    assert any("gone is not defined" in one for one in answer["complaints"])
    assert any(name.endswith("missing.png") for name in answer["loaded"])


@pytest.mark.parametrize("wide", [500, 800, 1280])
def test_no_screen_is_scrolled_sideways(browser: Browser, wide: int) -> None:
    question = "return [document.documentElement.scrollWidth, innerWidth]"
    for made in (rivals(), outside()):
        scrolled, screen = browser.ask(diagnosis_page(made), question, wide, 900)["told"]
        assert screen == wide
        assert scrolled <= screen


def test_a_phone_shows_one_column_within_its_width(browser: Browser) -> None:
    question = """const frame = document.createElement("iframe");
      const own = document.documentElement.outerHTML.replace(/<script>[^]*?<\\/script>/g, "");
      frame.style.cssText = "width:380px;height:800px;border:0";
      document.body.replaceChildren(frame);
      frame.contentDocument.write(own);
      const root = frame.contentDocument.documentElement;
      const chart = frame.contentDocument.querySelector(".chart").getBoundingClientRect();
      const table = frame.contentDocument.querySelector("table.errors").getBoundingClientRect();
      const text = frame.contentDocument.querySelector(".y-tick");
      return {wide: root.scrollWidth, right: chart.right, below: table.top > chart.bottom,
              letters: parseFloat(frame.contentWindow.getComputedStyle(text).fontSize)}"""
    answer = browser.ask(diagnosis_page(rivals()), question, WIDE, HIGH)
    told = answer["told"]
    assert told["wide"] <= 380
    assert 300 < told["right"] <= 380
    assert told["below"]
    assert told["letters"] >= 11.0


def test_the_switch_shows_another_recording_and_signal(browser: Browser) -> None:
    question = """const shown = () => [...document.querySelectorAll(".panel")]
        .filter((panel) => panel.getBoundingClientRect().height > 0)
        .map((panel) => panel.dataset.recording + " " + panel.dataset.signal);
      const told = [shown()];
      const list = document.querySelector(".switch select");
      list.value = "rec2.csv"; list.dispatchEvent(new Event("change")); told.push(shown());
      document.querySelector(".switch button[value=position]").click(); told.push(shown());
      return told"""
    answer = browser.ask(diagnosis_page(TWO_RECORDINGS), question, WIDE, HIGH)
    assert answer["complaints"] == []
    assert answer["told"] == [
        ["rec3.csv torque command"],
        ["rec2.csv torque command"],
        ["rec2.csv position"],
    ]


def test_curves_are_read_and_zoomed(browser: Browser) -> None:
    question = """const plot = document.querySelector(".panel .plot");
      const at = plot.getBoundingClientRect();
      const point = (kind, share) => plot.dispatchEvent(new PointerEvent(kind, {pointerId: 1,
        clientX: at.left + share * at.width, clientY: at.top + 20, bubbles: true}));
      plot.setPointerCapture = () => {};
      const ends = () => [...plot.closest(".panel").querySelectorAll(".x-tick")]
        .map((label) => Number(label.textContent));
      point("pointermove", 0.25);
      const read = document.querySelector(".read-out").textContent;
      const whole = ends();
      point("pointerdown", 0.5); point("pointermove", 0.6); point("pointerup", 0.6);
      const near = ends();
      plot.dispatchEvent(new MouseEvent("dblclick", {bubbles: true}));
      return {read, whole, near, again: ends()}"""
    answer = browser.ask(diagnosis_page(friction()), question, WIDE, HIGH)
    told, curve = answer["told"], friction().curves[1]
    assert answer["complaints"] == []
    assert told["read"].startswith("12.5 s: recorded ")
    row = round((12.5 - float(curve.time[0])) * 1000)
    assert f"recorded {curve.recorded[row]:.4g}".rstrip("0") in told["read"]
    assert told["read"].endswith("N\u00a0m")
    begin, end = 13.0, 13.2
    assert begin - 0.01 <= min(told["near"]) < max(told["near"]) <= end + 0.01
    assert len(told["near"]) >= 3
    assert told["again"] == told["whole"]


def test_the_page_is_whole_without_its_script(browser: Browser) -> None:
    page = re.sub(r"<script>.*?</script>", "", diagnosis_page(TWO_RECORDINGS), flags=re.DOTALL)
    question = """document.querySelectorAll("details").forEach((one) => { one.open = true; });
      return {charts: [...document.querySelectorAll(".panel .area")]
                .map((area) => area.getBoundingClientRect().height),
              table: box("table.errors"), script: document.documentElement.dataset.script}"""
    answer = browser.ask(page, question, WIDE, HIGH)
    assert answer["complaints"] == []
    assert "script" not in answer["told"]
    assert len(answer["told"]["charts"]) == 8  # two recordings, two signals, each with its error
    assert min(answer["told"]["charts"]) > 80.0
    assert answer["told"]["table"][3] <= HIGH


@pytest.mark.parametrize(
    "options", [(), ("--blink-settings=preferredColorScheme=0",)], ids=["light", "dark"]
)
def test_the_page_is_drawn(browser: Browser, options: tuple[str, ...]) -> None:
    picture = browser.picture(diagnosis_page(rivals()), WIDE, HIGH, *options)
    assert picture.startswith(b"\x89PNG")
    empty = browser.picture("<!DOCTYPE html><title>empty</title>", WIDE, HIGH)
    assert len(picture) > 8 * len(empty)


def test_dark_and_light_are_different_pictures(browser: Browser) -> None:
    page = diagnosis_page(friction())
    dark = browser.picture(page, WIDE, HIGH, "--blink-settings=preferredColorScheme=0")
    assert dark != browser.picture(page, WIDE, HIGH)


CLIPPED = """const cut = (root) => [...root.querySelectorAll(".scroll,.legend,.law")]
    .filter((one) => one.scrollWidth > one.clientWidth + 1).map((one) => one.textContent);
  const frame = document.createElement("iframe");
  const own = document.documentElement.outerHTML.replace(/<script>[^]*?<\\/script>/g, "");
  frame.style.cssText = "width:480px;height:800px;border:0";
  document.body.replaceChildren(frame);
  frame.contentDocument.write(own);
  return cut(frame.contentDocument)"""


@pytest.mark.parametrize("made", [with_law(), rivals(), nothing()], ids=["law", "rivals", "none"])
def test_no_table_is_cut_off_at_480_pixels(browser: Browser, made: Diagnosis) -> None:
    assert browser.ask(diagnosis_page(made), CLIPPED, WIDE, HIGH)["told"] == []


def test_control_a_table_that_stays_wide_is_cut_off(browser: Browser) -> None:
    page = re.sub(r'class="[^"]*\bstack"', "", diagnosis_page(with_law()))
    page = page.replace("tbody th{white-space:normal}", "")
    assert browser.ask(page, CLIPPED, WIDE, HIGH)["told"] != []
