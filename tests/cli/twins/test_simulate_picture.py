"""`gmfbo simulate --out X.html`: a recording, its simulations, and what is left, as one page."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from gmfbo.cli import main
from gmfbo.sources.fmu_file.models import models_folder
from tests.pages.headless_browser import NO_BROWSER, Browser, browser_path

SERVO = models_folder() / "servo_axis.toml"
HEAVY = 0.018
"""[kg.m2] The servo's inertia in its augmented twin; the nominal one has 0.01."""


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def complaint(capsys: pytest.CaptureFixture[str]) -> str:
    text = capsys.readouterr().err
    assert text.startswith("gmfbo: ")
    assert text.count("\n") == 1
    return text


def twin_file(folder: Path, origin: str = "") -> Path:
    """The servo with more inertia, as an augmented twin would hold it."""
    text = SERVO.read_text(encoding="utf-8").replace(
        'fmu = "servo_axis.fmu"', f'fmu = "{SERVO.with_suffix(".fmu").as_posix()}"\n{origin}'
    )
    path = folder / "augmented.toml"
    path.write_text(f"{text}\n[parameters]\ninertia = {HEAVY}\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A step of the heavier axis."""
    folder = tmp_path_factory.mktemp("recorded")
    assert run("simulate", twin_file(folder), "--out", folder / "run <1>.csv") == 0
    return folder / "run <1>.csv"


def curves(page: Path) -> list[dict[str, Any]]:
    text = page.read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="curves">(.*?)</script>', text)
    assert found is not None
    told: list[dict[str, Any]] = json.loads(found[1])
    return told


def test_each_compared_signal_is_drawn_as_recorded_and_as_simulated(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "run.html"
    assert run("simulate", SERVO, "--reference", recording, "--out", page) == 0
    shown = capsys.readouterr().out
    with FmuTwin(SERVO) as twin:
        recorded = Recording.read(recording, twin)
        simulated = twin.run({}, recorded)
    drawn = curves(page)
    assert len(drawn) == 2
    for curve, signal in zip(drawn, ("position", "torque_command"), strict=True):
        assert (curve["signals"], curve["errors"]) == (["recorded", "twin"], ["twin"])
        np.testing.assert_allclose(curve["time"], recorded.time, atol=1e-7)
        for name, holder in (("recorded", recorded), ("twin", simulated)):
            values = holder.signal(signal)
            np.testing.assert_allclose(
                curve["values"][name], values, rtol=1e-4, atol=1e-9 + 1e-5 * np.ptp(values)
            )
    text = page.read_text(encoding="utf-8")
    assert text.count('<figure class="panel"') == 2
    assert "run &lt;1&gt;.csv" in text
    assert "run <1>.csv" not in text
    assert not re.search(r"(?:src|href)=|https?://(?!www\.w3\.org)", text)
    told = float(re.search(r"position +([\d.]+) %", shown)[1])  # type: ignore[index]
    assert f"position {told:.2g} %" in text


def test_an_augmented_twin_is_drawn_beside_the_one_that_it_names_as_its_origin(
    recording: Path, tmp_path: Path
) -> None:
    page = tmp_path / "both.html"
    twin = twin_file(tmp_path, f'origin = "{SERVO.as_posix()}"')
    assert run("simulate", twin, "--reference", recording, "--out", page) == 0
    for curve in curves(page):
        assert curve["errors"] == ["nominal", "twin"]
        left = {
            name: float(
                np.abs(np.subtract(curve["values"]["recorded"], curve["values"][name])).max()
            )
            for name in curve["errors"]
        }
        assert left["twin"] < 1e-3 * left["nominal"]
    assert re.search(r"position [\d.]+ % before, 0(\.0+)? % now", page.read_text(encoding="utf-8"))


def test_settings_hold_for_both_twins(recording: Path, tmp_path: Path) -> None:
    """Control: the same gain moves the nominal twin too."""
    twin = twin_file(tmp_path, f'origin = "{SERVO.as_posix()}"')
    nominal = []
    for gain in (20.0, 60.0):
        page = tmp_path / f"{gain}.html"
        given = ("--set", f"kp={gain}", "--set", f"inertia={HEAVY}")
        assert run("simulate", twin, "--reference", recording, *given, "--out", page) == 0
        values = curves(page)[0]["values"]
        assert values["nominal"] == values["twin"]
        nominal.append(values["nominal"])
    assert nominal[0] != nominal[1]


def test_an_origin_that_is_gone_is_told_and_the_twin_drawn_alone(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "alone.html"
    twin = twin_file(tmp_path, 'origin = "moved.toml"')
    assert run("simulate", twin, "--reference", recording, "--out", page) == 0
    said = "origin = 'moved.toml' is not there; the twin is drawn alone"
    assert f"! {said}" in capsys.readouterr().out
    assert "moved.toml" in page.read_text(encoding="utf-8")
    assert curves(page)[0]["errors"] == ["twin"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--out", "x.html"), "a picture needs a recording beside the twin, got none"),
        (("--reference", "REC", "--out", "no/x.html"), "--out: cannot write"),
        (("--reference", "BARE", "--out", "x.html"), "holds none of the twin's outputs (position"),
        (("--reference", "gone.csv", "--out", "x.html"), "gone.csv"),
        (("--reference", "REC", "--out", "x.pdf"), "expected a file ending in .csv, .h5 or .html"),
    ],
)
def test_a_picture_that_cannot_be_drawn_is_one_line(
    arguments: tuple[str, ...],
    said: str,
    recording: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bare.csv").write_text("time [s],reference [rad]\n0,0\n0.001,0\n0.002,1\n")
    places = {"REC": recording, "BARE": tmp_path / "bare.csv"}
    capsys.readouterr()
    assert run("simulate", SERVO, *(places.get(word, word) for word in arguments)) == 2
    assert said in complaint(capsys)
    assert not (tmp_path / "x.html").exists()


@pytest.mark.skipif(browser_path() is None, reason=NO_BROWSER)
def test_the_picture_comes_alive_in_a_browser_without_a_network(
    recording: Path, tmp_path: Path
) -> None:
    page = tmp_path / "both.html"
    twin = twin_file(tmp_path, f'origin = "{SERVO.as_posix()}"')
    assert run("simulate", twin, "--reference", recording, "--out", page) == 0
    question = """return {ready: document.documentElement.dataset.script,
      shown: document.querySelectorAll(".panel:not([hidden])").length,
      lines: document.querySelectorAll(".panel:not([hidden]) .area .line").length}"""
    path = browser_path()
    assert path is not None
    answer = Browser(path, tmp_path).ask(page.read_text(encoding="utf-8"), question, 1280, 800)
    assert (answer["complaints"], answer["loaded"]) == ([], [])
    assert answer["told"] == {"ready": "ready", "shown": 1, "lines": 5}


def test_a_signal_that_has_no_error_leaves_the_others_theirs(
    tmp_path: Path, recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A channel that was not connected: blank, or stuck at one value."""
    header, *rows = recording.read_text(encoding="utf-8").splitlines()
    while header.startswith("#"):
        header, *rows = rows
    place = [name.split(" ")[0] for name in header.split(",")].index("position")
    for value, said in (("", "holds no value"), ("0.5", "'position' is constant")):
        cells = [row.split(",") for row in rows]
        text = [",".join([*c[:place], value, *c[place + 1 :]]) for c in cells]
        path = tmp_path / "stuck.csv"
        path.write_text("\n".join([header, *text]) + "\n", encoding="utf-8")
        out = tmp_path / "out.csv"
        assert run("simulate", twin_file(tmp_path), "--reference", path, "--out", out) == 0
        told = capsys.readouterr()
        assert said in told.out + told.err
        assert re.search(r"^torque_command +[\d.e-]+ %$", told.out, re.MULTILINE)
