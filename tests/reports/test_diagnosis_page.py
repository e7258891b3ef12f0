"""The report page: every number, every text escaped, nothing from the network."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.curve import Curve
from gmfbo.diagnosis.named_effect import NotTestable
from gmfbo.diagnosis.plain_words import number, percent
from gmfbo.physics import CATALOGUE
from gmfbo.reports.diagnosis_page import diagnosis_page
from tests.diagnosis.example_diagnoses import (
    FRICTION,
    friction,
    nothing,
    outside,
    parameters,
    rivals,
    too_little,
)
from tests.reports.page_text import PageText

EVIL = "<b>\"&'</b><script>alert(1)</script>"


def leaves(content: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Each value of a JSON with the names that lead to it."""
    if isinstance(content, dict):
        for name, item in content.items():
            yield from leaves(item, (*path, name))
    elif isinstance(content, list):
        for item in content:
            yield from leaves(item, path)
    else:
        yield path, content


@pytest.mark.parametrize("made", [friction(), rivals(), nothing(), parameters(), too_little()])
def test_the_page_shows_every_number_of_the_json(made: Diagnosis) -> None:
    shown = " ".join(PageText(diagnosis_page(made)).text)
    content = json.loads(made.to_json())
    checked = 0
    for path, value in leaves(content):
        if isinstance(value, bool) or not isinstance(value, (int, float)) or path == ("schema",):
            continue
        share = path[0] == "fit"
        digits = 2 if path[-1] == "probability" else 5 if path[0] == "location" else 4
        said = percent(value) if share else number(value, digits)
        assert said in shown, (path, value)
        checked += 1
    assert checked > 15


@pytest.mark.parametrize("made", [friction(), rivals(), outside(), nothing(), too_little()])
def test_the_page_shows_every_text_of_the_json(made: Diagnosis) -> None:
    shown = " ".join(PageText(diagnosis_page(made)).text)
    for path, value in leaves(json.loads(made.to_json())):
        if isinstance(value, str) and path[-1] not in ("verdict", "unit", "unit_x", "unit_y"):
            words = value.replace("_", " ")
            assert value in shown or words in shown or words.capitalize() in shown, (path, value)


def test_the_verdict_is_the_headline() -> None:
    page = diagnosis_page(friction())
    assert f"<h1>{friction().sentence}</h1>" in page


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
        location=replace(made.location, region=EVIL),
        fit=replace(
            made.fit, held_out=(EVIL,), fitted_on=(EVIL,),
            signals={EVIL: made.fit.signals["position"]},
        ),
        shape=replace(shape, port=EVIL, against=EVIL, unit_x=EVIL, unit_y=EVIL),
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
    assert not {"b", "script"} & set(read.tags)
    assert sum(EVIL in text for text in read.text) > 20
    assert any(EVIL in value for name, value in read.attributes if name == "aria-label")


@pytest.mark.parametrize("made", [friction(), outside(), nothing(), evil()])
def test_the_page_loads_nothing(made: Diagnosis) -> None:
    page = diagnosis_page(made)
    read = PageText(page)
    assert not {"script", "link", "img", "iframe", "object"} & set(read.tags)
    assert not [value for name, value in read.attributes if name in ("src", "href", "style")]
    assert "url(" not in page
    assert "@import" not in page


def test_held_out_recordings_come_first_and_open() -> None:
    made = friction()
    seen = tuple(replace(curve, recording="rec0.csv") for curve in made.curves)
    page = diagnosis_page(replace(made, curves=(*seen, *made.curves)))
    first, second = page.index("rec3.csv, unseen by the fit"), page.index("rec0.csv, fitted on")
    assert first < page.index("<details>") < second


def test_a_model_that_is_not_there_has_no_line() -> None:
    curve = nothing().curves[0]
    gone = np.full(curve.time.shape, np.nan)
    made = replace(nothing(), curves=(replace(curve, augmented=gone),))
    shown = PageText(diagnosis_page(made)).text
    assert "parameters only" in shown
    assert shown.count("augmented") == 1  # the head of the table's column


def test_time_windows_are_shaded_in_their_recording() -> None:
    made = friction()
    assert diagnosis_page(made).count('class="window"') == 4  # two signals, each with its error
    other = tuple(replace(curve, recording="rec1.csv") for curve in made.curves)
    assert 'class="window"' not in diagnosis_page(replace(made, curves=other))


def test_rivals_come_with_what_would_tell_them_apart() -> None:
    effect = replace(FRICTION, indistinguishable_from=("asymmetric_friction",))
    page = diagnosis_page(replace(friction(), effects=(effect,)))
    assert CATALOGUE["coulomb_friction"].confused_with["asymmetric_friction"] in page


def test_a_page_without_curves_is_whole() -> None:
    read = PageText(diagnosis_page(replace(outside(), curves=())))
    assert read.tags.count("svg") == 2  # the shape and its legend


def test_a_long_recording_gives_a_small_page() -> None:
    time = np.arange(200_000, dtype=np.float64) * 1e-3
    noise = np.random.default_rng(0).normal(size=time.size)
    curve = Curve("long.csv", "position", "rad", time, noise, noise, noise, noise)
    assert len(diagnosis_page(replace(friction(), curves=(curve,)))) < 200_000
