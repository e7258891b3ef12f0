"""The report page: numbers held against the JSON in it, texts escaped, nothing from the network."""

from __future__ import annotations

import json
import re
import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.page.first_screen import unbroken
from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.diagnosis.result.curve import Curve
from gmfbo.diagnosis.result.explained import Remainder
from gmfbo.diagnosis.result.named_effect import NotTestable, RivalShare
from gmfbo.pages.marked_number import json_path
from gmfbo.physics import CATALOGUE
from tests.diagnosis.example_diagnoses import (
    FRICTION,
    friction,
    late,
    nothing,
    outside,
    parameters,
    remaining,
    rivals,
    too_little,
    too_narrow,
    weak,
    with_law,
)
from tests.pages.page_text import PageText, at_path, rounds_to

ALL = [
    friction(),
    rivals(),
    nothing(),
    parameters(),
    too_narrow(),
    outside(),
    too_little(),
    weak(),
    late(),
    remaining(),
]
EVIL = "<b>\"&'</b><script>alert(1)</script>"
# What the page does not print: the shape's points are drawn, predictions are for `experiment`.
NOT_PRINTED = ("schema", "shape", "latent", "predictions")


def numbers_of(content: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Places of all numbers of a JSON."""
    if isinstance(content, dict):
        return [p for name, one in content.items() for p in numbers_of(one, (*path, name))]
    if isinstance(content, list):
        return [p for k, one in enumerate(content) for p in numbers_of(one, (*path, k))]
    is_number = isinstance(content, (int, float)) and not isinstance(content, bool)
    return [path] if is_number and path[0] not in NOT_PRINTED else []


def texts_of(content: Any) -> list[str]:
    """All names and texts of a JSON."""
    if isinstance(content, dict):
        return [*content, *(text for one in content.values() for text in texts_of(one))]
    if isinstance(content, list):
        return [text for one in content for text in texts_of(one)]
    return [content] if isinstance(content, str) else []


@pytest.mark.parametrize("made", ALL)
def test_every_marked_number_is_that_of_the_json(made: Diagnosis) -> None:
    content = json.loads(made.to_json())
    numbers = PageText(diagnosis_page(made)).numbers
    assert len(numbers) > 20
    for number in numbers:
        assert rounds_to(number, at_path(content, number.path)), number


@pytest.mark.parametrize("made", ALL)
def test_every_number_of_the_json_is_on_the_page(made: Diagnosis) -> None:
    content = json.loads(made.to_json())
    shown = {number.path for number in PageText(diagnosis_page(made)).numbers}
    # A parameter that cannot be seen keeps its nominal value; its interval says nothing.
    hidden = {n for n, one in made.parameters.items() if not one.identifiable}
    for path in numbers_of(content):
        if path[0] != "parameters" or path[1] not in hidden or path[2] == "nominal":
            assert json_path(path) in shown, path


@pytest.mark.parametrize("made", ALL)
def test_no_table_has_a_number_without_its_place(made: Diagnosis) -> None:
    known = {text.replace("_", " ") for text in texts_of(json.loads(made.to_json()))}
    known |= {text for law in CATALOGUE.values() for text in law.confused_with.values()}
    known |= {p.words for law in CATALOGUE.values() for p in law.parameters}
    for text in PageText(diagnosis_page(made)).bare:
        said = text.replace("_", " ").replace("95 % interval", "")
        if re.search(r"\d", said):
            assert any(said.strip() in one or one in said for one in known if one), text


def test_a_number_that_is_not_that_of_the_json_is_seen() -> None:
    """Negative control: the check fails on a page of another diagnosis."""
    content = json.loads(rivals().to_json())
    changed = replace(FRICTION, evidence=999.0, threshold=17.0)
    page = PageText(diagnosis_page(replace(rivals(), effects=(changed, *rivals().effects[1:]))))
    wrong = [n.path for n in page.numbers if not rounds_to(n, at_path(content, n.path))]
    assert wrong == ["effects.0.evidence", "effects.0.threshold"]


@pytest.mark.parametrize("made", ALL)
def test_the_page_holds_the_whole_json(made: Diagnosis) -> None:
    assert PageText(diagnosis_page(made)).content == json.loads(made.to_json())


def test_a_small_remainder_is_told_once() -> None:
    left = Remainder(0.002, "torque", "velocity", "throughout")
    page = diagnosis_page(replace(outside(), remainder=left))
    assert "<li>less than 1 % of what is more than noise" in page.replace("\xa0", " ")


@pytest.mark.parametrize("made", [friction(), rivals(), outside(), nothing(), too_little()])
def test_the_headline_and_what_follows_it_are_the_verdict(made: Diagnosis) -> None:
    page = diagnosis_page(made)
    headline = re.search(r'<h1 id="verdict">([^<]+)</h1>', page)
    rest = re.search(r'</h1><p class="lead">([^<]+)</p>', page)
    assert headline is not None
    assert len(headline[1]) < 300
    told = [headline[1], rest and rest[1]]
    assert " ".join(filter(None, told)).replace("\xa0", " ") == made.sentence


@pytest.mark.parametrize(
    ("text", "whole"),
    [
        ("about 0.19 N m when", "0.19\u00a0N\u00a0m"),
        ("is 0.0105 kg m2 instead", "0.0105\u00a0kg\u00a0m2"),
        ("up to 0.4 N m/rad, at", "0.4\u00a0N\u00a0m/rad"),
        ("from 6.8 % to", "6.8\u00a0%"),
        ("it moves 3 times", "3 times"),
    ],
)
def test_a_number_stays_on_the_line_of_its_unit(text: str, whole: str) -> None:
    assert whole in unbroken(text)
    assert unbroken(text).replace("\u00a0", " ") == text


def test_a_verdict_that_nothing_is_missing_says_what_was_looked_for() -> None:
    page = diagnosis_page(nothing())
    told = r"<b>Looked for, and not found</b>: backlash from <data [^>]+>810</data>\xa0µrad"
    assert re.search(told, page)


def test_the_named_law_is_drawn_over_the_curve_on_an_axis_of_both() -> None:
    page = diagnosis_page(with_law())
    drawn = page[page.index('<div class="chart shape"') :]
    ends = re.search(r'data-y="(\S+) (\S+)"', drawn)
    latent = with_law().latent
    assert ends is not None
    assert latent is not None
    (low, high), curve, law = map(float, ends.groups()), latent.y, latent.law_y
    assert low < min(*curve, *law) < max(*curve, *law) < high
    # The band at an end that the motion hardly reaches is a hundred times as wide.
    assert high - low < 2.0 * (max(*curve, *law) - min(*curve, *law))
    assert 'class="line law-line"' in drawn
    assert "named law: coulomb friction" in page
    assert 'class="line law-line"' not in diagnosis_page(outside())


def test_no_word_of_the_engine_is_left_unexplained() -> None:
    page = re.sub(r"<script.*?</script>", "", diagnosis_page(with_law()), flags=re.DOTALL)
    for word in ("named from 30", "What would have shown", "<td>cut", "<td>held", ">evidence<"):
        assert word not in page


def test_a_recording_among_many_keeps_its_curve() -> None:
    """However many are shown: a point for each pixel of the chart, not a polygon."""
    many = tuple(
        replace(curve, recording=f"rec{k}.csv") for k in range(30) for curve in friction().curves
    )
    page = diagnosis_page(replace(friction(), curves=many))
    paths = re.findall(r'<path class="line recorded" d="([^"]+)"', page)
    paths = [path for path in paths if "L" in path]  # not those of legends
    assert len(paths) == 60
    assert min(path.count("L") for path in paths) > 600


def evil() -> Diagnosis:
    """Every text of a diagnosis as somebody hostile would give it."""
    effect = replace(
        FRICTION,
        name=EVIL,
        port=EVIL,
        statement=EVIL,
        equation=EVIL,
        parameters={EVIL: replace(FRICTION.parameters["level"], unit=EVIL)},
        evidence_per_recording={EVIL: 1.0},
        indistinguishable_from=(EVIL,),
        rivals=(RivalShare(EVIL, 0.5),),
    )
    made = rivals()
    assert made.next_experiment is not None
    shape = outside().shape
    assert shape is not None
    return replace(
        made,
        effects=(effect,),
        parameters={EVIL: replace(made.parameters["mech.J"], unit=EVIL)},
        combinations=(replace(made.combinations[0], expression=EVIL),),
        alignment={EVIL: replace(made.alignment["torque_command"], logged=EVIL)},
        detectable={EVIL: replace(made.detectable["backlash"], parameter=EVIL, unit=EVIL)},
        location=replace(
            made.location,
            region=EVIL,
            times=tuple(window._replace(recording=EVIL) for window in made.location.times),
        ),
        fit=replace(
            made.fit, held_out=(EVIL,), fitted_on=(EVIL,),
            signals={EVIL: made.fit.signals["position"]},
        ),
        shape=replace(shape, port=EVIL, against=EVIL, unit_x=EVIL, unit_y=EVIL),
        residual_tests=tuple(
            replace(one, recording=EVIL, signal=EVIL) for one in made.residual_tests
        ),
        next_experiment=replace(
            made.next_experiment, reference=EVIL, separates=(EVIL,), predicted={EVIL: EVIL},
            why=EVIL,
        ),
        not_testable=(NotTestable(EVIL, EVIL),),
        notes=(EVIL,),
        versions={EVIL: EVIL},
        curves=tuple(replace(curve, recording=EVIL, signal=EVIL, unit=EVIL)
                     for curve in made.curves),
    )  # fmt: skip


def test_every_text_is_escaped() -> None:
    page = diagnosis_page(evil())
    read = PageText(page)
    ours = PageText(diagnosis_page(friction()))
    assert read.tags.count("script") == ours.tags.count("script")
    assert "alert(1)" not in read.embedded[""]
    assert sum(EVIL in text for text in read.text) > 20
    assert any(EVIL in value for name, value in read.attributes if name == "aria-label")
    assert read.content == json.loads(evil().to_json())


@pytest.mark.parametrize("made", [friction(), outside(), nothing(), evil()])
def test_the_page_loads_nothing(made: Diagnosis) -> None:
    page = diagnosis_page(made)
    read = PageText(page)
    assert not {"link", "img", "iframe", "object", "base"} & set(read.tags)
    links = [value for name, value in read.attributes if name in ("src", "href", "style")]
    assert all(value.startswith("#") for value in links)
    anchors = {value for name, value in read.attributes if name == "id"}
    assert {value[1:] for value in links} <= anchors
    for word in ("url(", "@import", "fetch(", "XMLHttpRequest", "import("):
        assert word not in page


def test_held_out_recordings_come_first_and_open() -> None:
    made = friction()
    seen = tuple(replace(curve, recording="rec0.csv") for curve in made.curves)
    page = diagnosis_page(replace(made, curves=(*seen, *made.curves)))
    first, second = page.index("in rec3.csv, unseen by the fit"), page.index("in rec0.csv, fitted")
    assert first < page.index("<details") < second


def test_the_signal_that_improves_most_comes_first() -> None:
    page = diagnosis_page(friction())
    assert page.index('data-signal="torque command"') < page.index('data-signal="position"')


def test_a_model_that_is_not_there_has_no_line() -> None:
    curve = nothing().curves[0]
    gone = np.full(curve.time.shape, np.nan)
    page = diagnosis_page(replace(nothing(), curves=(replace(curve, augmented=gone),)))
    body = page[page.index("<body>") :]
    assert 'class="line before"' in body
    assert 'class="line after"' not in body


def test_augmented_is_drawn_over_recorded() -> None:
    page = diagnosis_page(friction())
    panel = page[page.index('class="area"') : page.index("</svg>", page.index('class="area"'))]
    order = re.findall(r'class="line (\w+)"', panel)
    assert order == ["recorded", "before", "after"]


def test_time_windows_are_shaded_in_their_recording() -> None:
    made = friction()
    assert diagnosis_page(made).count('class="window"') == 4  # two signals, each with its error
    other = tuple(replace(curve, recording="rec1.csv") for curve in made.curves)
    assert 'class="window"' not in diagnosis_page(replace(made, curves=other))


def test_the_guilty_part_of_the_loop_is_marked() -> None:
    page = diagnosis_page(friction())
    assert re.findall(r'<g class="guilty">.*?<text[^>]*>(\w+)</text>', page) == ["plant"]


def test_rivals_come_with_their_probability_and_what_would_tell_them_apart() -> None:
    page = diagnosis_page(rivals())
    told = CATALOGUE["constant_torque_offset"].confused_with["gravity_torque"]
    assert told in page
    assert '<data data-path="effects.1.rivals.1.probability">0.20</data>' in page


def test_a_column_that_leads_is_called_early() -> None:
    made = friction()
    early = replace(made.alignment["torque_command"], shift=-4.3e-5)
    page = diagnosis_page(replace(made, alignment={"torque_command": early}))
    assert re.search(r'data-scale="-1e-06">43</data>\xa0µs early', page)


def test_a_page_without_curves_is_whole() -> None:
    read = PageText(diagnosis_page(replace(outside(), curves=())))
    assert ("class", "first alone") in read.attributes
    assert ("class", "chart shape") in read.attributes
    assert read.embedded["curves"] == "[]"


def test_many_long_recordings_give_a_page_below_2_mb_in_a_second() -> None:
    times = np.arange(30_000, dtype=np.float64) * 1e-3
    noise = np.random.default_rng(0).normal(size=times.size)
    names = ("position", "velocity", "torque_command")
    curves = tuple(
        Curve(f"long{k}.csv", name, "rad", times, noise, 1.1 * noise, 1.2 * noise, 0.9 * noise)
        for k in range(20)
        for name in names
    )
    started = time.process_time()
    page = diagnosis_page(replace(friction(), curves=curves))
    assert time.process_time() - started < 4.0  # a quarter of it alone on a desk
    assert len(page.encode()) < 2_000_000
