"""Study files: what is understood, and how the rest is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo.errors import StudyFileError
from gmfbo.tuning.study_file.study_file import parse_study, read_study_file
from gmfbo.tuning.study_file.study_sections import StudyFile

SOURCES = '[is1]\ntwin = "plant.toml"\n[is2]\ntwin = "twin.toml"\n'
OWN = '[objective]\nmetrics = "mine.py:effort"\nweights = { effort = 1.0 }\n'

FULL = """
name = "axis 3"
seed = 7
method = "gmfbo"
out = "axis3.study"
[is1]
twin = "plant.toml"
change = { after_runs = 4, parameters = { "friction.scale" = 2.0 } }
[is2]
twin = "twin.toml"
parameters = { "map.noise" = 0.5, "map.seed" = "seed" }
[gains]
"ctl.Kp" = [30.0, 200.0]
"ctl.Kd" = { low = 2.0, high = 10.0, scale = "log" }
"ctl.taps" = { low = 1, high = 5, integer = true }
"ctl.Ki" = 0.5
[reference]
step = 1.0
at = 0.1
horizon = 1.0
[objective]
signal = "position"
weights = { overshoot = 0.02, transient_time = 0.20, rise_time = 0.70, settling_time = 0.20 }
normalise = 10
[budget]
initial_is1 = 2
initial_is2 = 10
iterations = 20
is3_per_run = 4
"""


def parse(text: str) -> StudyFile:
    return parse_study(text, label="axis.toml", default_name="axis")


def test_a_full_study_is_understood() -> None:
    study = parse(FULL)
    assert (study.name, study.seed, study.folder_name) == ("axis 3", 7, "axis3.study")
    assert study.is1.change is not None
    assert study.is1.change.parameters == {"friction.scale": 2.0}
    assert study.is2.parameters == {"map.noise": 0.5, "map.seed": "seed"}
    assert study.gains["ctl.Kp"].low == 30.0
    assert study.gains["ctl.Kd"].scale == "log"
    assert study.gains["ctl.taps"].integer
    assert study.gains["ctl.Ki"].low == study.gains["ctl.Ki"].high == 0.5
    assert study.objective.normalise.points == 10
    assert study.budget.most_queries == 20


def test_sources_are_enough_and_the_folder_takes_the_name(tmp_path: Path) -> None:
    path = tmp_path / "press.toml"
    path.write_text(SOURCES, encoding="utf-8")
    study, text = read_study_file(path)
    assert (study.name, study.folder_name, text) == ("press", "press.study", SOURCES)
    assert (study.budget.initial_is1, study.budget.initial_is2) == (2, 10)
    assert (study.budget.most_queries, study.budget.is3_per_run) == (20, 4)
    assert study.objective.weights["rise_time"] == 0.70


def test_a_budget_of_real_runs_bounds_the_queries() -> None:
    assert parse(SOURCES + "[budget]\nis1_runs = 22").budget.most_queries == 110
    both = parse(SOURCES + "[budget]\nis1_runs = 22\niterations = 50").budget
    assert (both.is1_runs, both.most_queries) == (22, 50)


def test_known_normalising_constants_are_taken() -> None:
    text = (
        "[objective]\nweights = { rise_time = 1.0 }\n"
        "normalise = { mean = { rise_time = 0.1 }, std = { rise_time = 0.02 } }"
    )
    constants = parse(SOURCES + text).objective.normalise
    assert (constants.mean, constants.std) == ({"rise_time": 0.1}, {"rise_time": 0.02})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name = ", r"axis\.toml: not a TOML file"),
        ('[is1]\ntwin = "a"', r"axis\.toml: \[is2\]: missing"),
        ('methd = "x"\n' + SOURCES, "unknown key 'methd'; did you mean 'method'"),
        (SOURCES + "[budget]\ninitial_is = 2", r"\[budget\]: unknown key 'initial_is'; did you"),
        (SOURCES + "[gains]\nk = [3.0, 1.0]", r"\[gains\] k: expected low <= high, got \[3, 1\]"),
        (SOURCES + '[gains]\nk = "x"', r"\[gains\] k: expected \[low, high\], a number or a table"),
        (
            SOURCES + '[gains]\nk = { low = 0.0, high = 1.0, scale = "log" }',
            r"\[gains\] k: a log scale needs a positive lower bound, got 0",
        ),
        (SOURCES + "[objective]\nweights = { rise = 1 }", "no metric 'rise'; did you mean 'rise_t"),
        (SOURCES + "[objective]\nweights = { rise_time = 0 }", "weights: expected at least one ab"),
        (
            SOURCES + OWN + 'units = { efort = "N.m" }',
            r"\[objective\] units: no metric 'efort' of your own .*; did you mean 'effort'\?",
        ),
        (SOURCES + OWN + 'units = { overshoot = "1" }', "the unit of 'overshoot' is known; leave"),
        (SOURCES + '[objective]\nunits = { effort = "N.m" }', "no metric 'effort' of your own"),
        (SOURCES + OWN + 'units = { effort = "<b>" }', r"units\.effort: String should match patt"),
        (SOURCES + "[objective]\nnormalise = 11", "at most initial_is2 = 10, got 11"),
        (SOURCES + "[objective]\nnormalise = { mean = { rise_time = 1 } }", "both mean and std"),
        (
            SOURCES + "[objective]\nnormalise = { mean = {rise_time = 1}, std = {rise_time = 1} }",
            "normalise: expected mean and std of 'overshoot'",
        ),
        (SOURCES + "[reference]\nstep = 0", "a height other than zero"),
        (SOURCES + '[reference]\nfile = "r.csv"\nstep = 2.0', "either file or step"),
        ('name = "a/b"\n' + SOURCES, "name: String should match pattern"),
        ("seed = -1\n" + SOURCES, "seed: Input should be greater than or equal to 0"),
        ("[is1]\n[is2]\ntwin = 'b'", r"\[is1\]: expected exactly one of twin = FILE, command"),
        (
            '[is1]\ncommand = "python bench.py"\n[is2]\ntwin = "b"',
            r"\[is1\] command: expected a list of words such as .*got 'python bench\.py'",
        ),
        (
            '[is1]\nask_tell = true\nretries = 1\n[is2]\ntwin = "b"',
            "time_limit and retries need a command",
        ),
        (
            '[is1]\ncommand = ["x"]\nrecorded = "y"\n[is2]\ntwin = "b"',
            "expected exactly one of twin",
        ),
        (
            '[is1]\nask_tell = true\nparameters = { a = 1 }\n[is2]\ntwin = "b"',
            "parameters, hidden and change need a twin that plays the plant",
        ),
        (
            '[is1]\ntwin = "a"\nparameters = { a = "sead" }\n[is2]\ntwin = "b"',
            r"\[is1\] parameters\.a: expected a number or \"seed\", got 'sead'",
        ),
    ],
)
def test_a_wrong_study_is_refused_in_one_line(text: str, message: str) -> None:
    with pytest.raises(StudyFileError, match=message) as refused:
        parse(text)
    assert "\n" not in str(refused.value)


def test_everything_wrong_is_said_at_once() -> None:
    with pytest.raises(StudyFileError, match=r"unknown key 'a'.*; .*unknown key 'b'"):
        parse(SOURCES + "[budget]\na = 1\nb = 2")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(StudyFileError, match=r"none\.toml: cannot read the study file: No such"):
        read_study_file(tmp_path / "none.toml")


def test_a_binary_file_is_not_a_study(tmp_path: Path) -> None:
    path = tmp_path / "x.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(StudyFileError, match="not UTF-8 text"):
        read_study_file(path)
