"""A diagnosis at a prompt, in a notebook and on a terminal of 80 by 24."""

from __future__ import annotations

import io
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from gmfbo.cli.diagnosis.diagnosis_display import DiagnosisDisplay
from gmfbo.cli.diagnosis.diagnosis_screen import screenful
from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.diagnosis.result.explained import FreeRun
from gmfbo.diagnosis.result.held_out_errors import SignalFit
from gmfbo.diagnosis.result.named_effect import IdentifiedValue
from tests.diagnosis.example_diagnoses import (
    FIT,
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
)

WRITTEN = tuple(
    Path("results/axis") / name
    for name in ("diagnosis.json", "report.html", "augmented.fmu", "augmented.toml")
)


def crowded() -> Diagnosis:
    """More effects, signals and words than a screen holds."""
    many = {f"value_{k}": IdentifiedValue(0.1, "N.m", 0.05, 0.15) for k in range(9)}
    effect = replace(FRICTION, parameters=many, indistinguishable_from=("backlash",) * 7)
    signals = {
        f"a_signal_with_a_long_name_{k}": SignalFit(0.3, 0.2, 0.1, 0.1, 0.05) for k in range(9)
    }
    return replace(
        rivals(),
        effects=(effect,) * 6,
        fit=replace(FIT, signals=signals),
        notes=("a remark that goes on and on " * 6,) * 5,
    )


def without_correction(diagnosis: Diagnosis) -> Diagnosis:
    """The same of an open-loop twin, each signal of which has errors without correction too."""
    signals = {
        name: replace(fit, free_run=FreeRun(0.41, 0.32, 0.021))
        for name, fit in diagnosis.fit.signals.items()
    }
    return replace(diagnosis, fit=replace(diagnosis.fit, signals=signals))


def everything() -> Diagnosis:
    """A crowded diagnosis of an open-loop axis that has every entry of the screen."""
    return replace(
        without_correction(crowded()),
        converged=False,
        alignment=late().alignment,
        parameters=remaining().parameters,
        remainder=remaining().remainder,
    )


@pytest.mark.parametrize(
    "made",
    [
        friction(),
        rivals(),
        outside(),
        nothing(),
        parameters(),
        too_narrow(),
        too_little(),
        crowded(),
        late(),
        replace(crowded(), converged=False, alignment=late().alignment),
        without_correction(crowded()),
        everything(),
    ],
)
def test_the_result_fits_a_screen(made: Diagnosis) -> None:
    lines = screenful(made, WRITTEN)
    assert len(lines) <= 23
    assert max(len(line) for line in lines) <= 79
    assert lines[-1].endswith("augmented.toml")


def test_values_of_a_fit_that_was_stopped_are_marked() -> None:
    told = "stopped before it had converged"
    stopped = replace(parameters(), converged=False)
    assert told in " ".join(screenful(stopped))
    assert told in diagnosis_page(stopped)
    assert json.loads(stopped.to_json())["converged"] is False


def test_control_values_of_a_fit_that_converged_are_not_marked() -> None:
    told = "stopped before it had converged"
    assert told not in " ".join(screenful(parameters()))
    assert told not in diagnosis_page(parameters())


def test_a_typical_screen_holds_all_that_matters() -> None:
    shown = "\n".join(screenful(rivals(), WRITTEN))
    for part in (
        "coulomb friction, probability 0.94",
        "level = 0.521 [0.493, 0.548] N m",
        "one of constant torque offset, gravity torque, elastic return (the",
        "recordings cannot tell them apart), probability 0.81",
        "as constant torque offset: level = 0.107 [0.0954, 0.12] N m",
        "31 %             30 %      6.0 %        5.1 %",
        "98 % of the error that physics can explain",
        "mech.J 0.12 -> 0.121 [0.119, 0.123] kg m2",
        "plant, where the velocity changes sign, rec2.csv 0.413-0.472 s ...",
        "3: sensor lag (the twin has no sensor port)",
        "play next.csv to tell constant torque offset from gravity",
        "612 simulations in 14.2 s, seed 7",
        "augmented.toml",
    ):
        assert part in shown


def test_a_crowded_screen_says_what_it_leaves_out() -> None:
    shown = "\n".join(screenful(crowded(), WRITTEN))
    assert "more         5 effects, 8 signals and 4 notes, see the report" in shown


@pytest.mark.parametrize("count", [1, 2, 4, 9])
def test_each_signal_is_on_the_screen_or_counted_with_and_without_correction(count: int) -> None:
    signals = {f"signal_{k}": SignalFit(0.3, 0.2, 0.1, 0.1, 0.05) for k in range(count)}
    closed = replace(friction(), fit=replace(FIT, signals=signals))
    for made in (closed, without_correction(closed)):
        lines = screenful(made, WRITTEN)
        shown = sum(line.startswith("signal ") for line in lines)
        free_runs = sum(line.startswith("  whole, uncorrected") for line in lines)
        counted = re.search(r"(\d+) signals?\b.*see the report", "\n".join(lines))
        assert shown + (int(counted[1]) if counted else 0) == count
        assert free_runs == (0 if made is closed else shown)


def test_a_long_path_is_never_cut() -> None:
    deep = Path("/" + "/".join(f"folder-{k}" for k in range(12))) / "diagnosis.json"
    assert any(str(deep.parent) in line for line in screenful(friction(), [deep]))


def test_a_prompt_shows_sentence_effects_and_errors() -> None:
    shown = repr(rivals())
    assert shown.startswith("<Diagnosis: missing_physics> Coulomb friction")
    assert "level = 0.521 [0.493, 0.548] N m" in shown
    assert "torque command" in shown


def test_a_notebook_shows_the_same_escaped() -> None:
    shown = replace(
        friction(), effects=(replace(FRICTION, statement="<b>&</b> is missing."),)
    )._repr_html_()
    assert "&lt;b&gt;&amp;&lt;/b&gt; is missing" in shown
    assert "level = 0.521 [0.493, 0.548] N m" in shown
    assert "<td>6.0 %</td>" in shown


def test_progress_is_drawn_on_a_terminal_only(capsys: pytest.CaptureFixture[str]) -> None:
    for terminal in (True, False):
        drawn = io.StringIO()
        console = Console(file=drawn, force_terminal=terminal, width=80)
        with DiagnosisDisplay(console, lines=True) as display:
            display.show("screening [120 runs]", 0.4)
            display.show("beyond the end", 1.2)
        assert bool(drawn.getvalue()) == terminal
        assert ("beyond the end" in drawn.getvalue()) == terminal
        assert bool(capsys.readouterr().err) != terminal


STAGES = (("running the twin", 0.0), ("screening", 0.2), ("screening", 0.3), ("judging", 0.9))


@pytest.mark.parametrize("lines", [True, False])
def test_without_a_terminal_each_stage_that_ended_may_be_a_line_with_its_seconds(
    lines: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    console = Console(file=io.StringIO(), force_terminal=False)
    with DiagnosisDisplay(console, lines=lines) as display:
        for stage, share in STAGES:
            display.show(stage, share)
    shown, said = capsys.readouterr()
    assert shown == ""
    told = re.fullmatch(r"running the twin: \d\.\d s\nscreening: \d\.\d s\n", said)
    assert told if lines else said == ""


def test_a_long_stage_is_cut_and_the_bar_stays() -> None:
    drawn = io.StringIO()
    console = Console(file=drawn, force_terminal=True, width=80, legacy_windows=False)
    with DiagnosisDisplay(console) as display:
        display.show("confirming backlash " * 9, 0.4)
    assert "40%" in drawn.getvalue()
    assert "confirming backlash confirming backlas..." in drawn.getvalue()
