"""The page of a running study: what it says is the store's, and it reloads until the end."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo.cli import main
from gmfbo.cli.tuning.live_study import LiveStudy
from gmfbo.errors import InputError
from gmfbo.plain_words import time_left
from gmfbo.reports.study import live_file
from gmfbo.reports.study.live_page import RELOAD_S, live_page
from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from tests.pages.headless_browser import NO_BROWSER, Browser, browser_path
from tests.pages.page_text import PageText
from tests.reports.study.example_studies import ExampleStudy, write_example_study

RELOAD = f'<meta http-equiv="refresh" content="{RELOAD_S}">'


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> StudyReview:
    return StudyReview.read(write_example_study(tmp_path_factory.mktemp("studies")))


@pytest.fixture
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write the page at every run."""
    monkeypatch.setattr(live_file, "_LEAST_S", 0.0)
    monkeypatch.setattr(live_file, "_SHARE", 1e9)


def plain(page: str) -> str:
    return " ".join(PageText(page).text)


def test_the_page_tells_the_best_gains_the_count_and_the_time_left(review: StudyReview) -> None:
    page = live_page(review, "running", 754.0)
    assert review.best is not None
    for name, value in review.best.gains.items():
        assert f"{name} = {value:.4g}" in page
    simulated = sum(run.trial.source != "IS1" for run in review.runs)
    assert f"About 13 min left. So far 5 real runs, {simulated} simulated." in page
    assert "4 of 4 queries done." in page
    newest = review.correction[-1]
    assert f"from {newest[1]:.3g} to {newest[2]:.3g} rad" in page
    assert "friction of 0.4 N m &lt;found&gt; by diagnosis" in page


def test_only_the_page_of_a_running_study_reloads(review: StudyReview) -> None:
    assert RELOAD in live_page(review, "running", None)
    for state in ("ended", "interrupted"):
        assert "http-equiv" not in live_page(review, state, None)
    assert "'gmfbo tune --resume' goes on" in plain(live_page(review, "interrupted", None))


def test_the_map_has_a_scale_and_the_units_of_the_gains(review: StudyReview) -> None:
    units = {"ctl.Kp": "N.m/rad", "ctl.Kd": "N.m.s/rad"}
    known = (*review.events, {"event": "begin", "origin": "..", "twins": {}, "units": units})
    told = replace(review, events=known)
    for page in (live_page(told, "running", None), study_page(told)):
        assert "ctl.Kp [N\u00a0m/rad]" in page
        scale = page[page.index('<figure class="scale">') :].partition("</figure>")[0]
        values = [float(text) for text in re.findall(r"<text[^>]*>([^<]+)</text>", scale)]
        assert values == sorted(set(values))
        assert scale.count("<rect") == 10
    # A study of before units were logged has names alone.
    assert "ctl.Kp [" not in live_page(review, "running", None)


def test_a_real_run_among_many_keeps_its_curve(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "many.study")
    with made.store:
        for _ in range(40):
            made.real(made.gains(), None)
        page = study_page(StudyReview.read(tmp_path / "many.study"))
    drawn = re.findall(r'"t":\[([^]]*)\]', PageText(page).embedded["trajectories"])
    assert max(row.count(",") + 1 for row in drawn) == 551  # every row of a real run


@pytest.mark.parametrize(
    ("seconds", "told"), [(0.0, "0 s"), (89.0, "89 s"), (754.0, "13 min"), (9000.0, "2.5 h")]
)
def test_a_time_to_come_is_told_roughly(seconds: float, told: str) -> None:
    assert time_left(seconds) == told


def pages_of(made: ExampleStudy, out: Path, *, fails: bool) -> Sequence[str]:
    """The page before the first run, after some, and at the end."""
    live, pages = LiveStudy.begin(out), []
    with live.following(made.store.location):
        pages.append(out.read_text(encoding="utf-8"))
        made.trial("IS2", made.gains())
        made.real(made.gains(), None)
        live.show()
        pages.append(out.read_text(encoding="utf-8"))
        if fails:
            raise KeyboardInterrupt
        made.end(made.gains())
    return [*pages, out.read_text(encoding="utf-8")]


@pytest.mark.usefixtures("eager")
def test_the_page_follows_the_study_and_stays_when_it_ends(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "live.study")
    with made.store:
        waiting, running, ended = pages_of(made, tmp_path / "live.html", fails=False)
    assert "Waiting for the first run" in waiting
    assert RELOAD in waiting
    assert RELOAD in running
    assert "Best gains so far: " in running
    assert "Best gains: " in ended
    assert RELOAD not in ended


def test_a_study_that_ended_without_success_does_not_say_yet(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "failed.study")
    with made.store:
        made.real(made.gains(), None, "failed")
    failed = StudyReview.read(tmp_path / "failed.study")
    assert "No real run has succeeded yet" in plain(live_page(failed, "running", None))
    assert "None of 1 real runs succeeded" in plain(live_page(failed, "ended", None))


@pytest.mark.usefixtures("eager")
def test_a_study_that_is_stopped_says_so_on_its_page(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "live.study")
    with made.store, pytest.raises(KeyboardInterrupt):
        pages_of(made, tmp_path / "live.html", fails=True)
    page = (tmp_path / "live.html").read_text(encoding="utf-8")
    assert "It was stopped" in page
    assert RELOAD not in page


@pytest.mark.usefixtures("eager")
def test_a_page_that_cannot_be_written_is_told_once_and_stops_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made, out = ExampleStudy(tmp_path / "live.study"), tmp_path / "live.html"
    with made.store, LiveStudy.begin(out).following(made.store.location):
        live = LiveStudy.begin(out)
        with live.following(made.store.location):
            made.real(made.gains(), None)
            out.unlink()
            out.mkdir()
            live.show()
            live.show()
            made.real(made.gains(), None)
        told = capsys.readouterr().err
        assert told.count("--html: cannot write") == 1
        assert "the study goes on without the page" in told


@pytest.mark.parametrize(
    ("name", "message"),
    [("page.txt", "expected a file name that ends in .html"), ("no/x.html", "make it first")],
)
def test_a_page_with_no_place_is_refused_before_the_study_runs(
    tmp_path: Path, name: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        LiveStudy.begin(tmp_path / name)


def test_watching_writes_the_page_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, out = write_example_study(tmp_path), tmp_path / "page.html"
    assert main(["watch", str(folder), "--html", str(out)]) == 0
    page = out.read_text(encoding="utf-8")
    assert "Best gains" in page
    assert RELOAD not in page
    assert main(["watch", str(folder), "--html", str(tmp_path / "page.txt")]) == 2
    assert "expected a file name that ends in .html" in capsys.readouterr().err


@pytest.mark.skipif(browser_path() is None, reason=NO_BROWSER)
def test_a_browser_loads_the_file_again_by_itself(tmp_path: Path, review: StudyReview) -> None:
    path = browser_path()
    assert path is not None
    browser = Browser(path, tmp_path)
    sooner = RELOAD.replace(f'"{RELOAD_S}"', '"1"')
    page = live_page(review, "running", None).replace(RELOAD, sooner)
    assert browser.loads_again(page, most=60.0)
    assert not browser.loads_again(page.replace(sooner, ""), most=6.0)
