"""A study with a limit on a margin: measured on the twin, and kept from the axis."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console

from gmfbo.cli.tuning import study_result
from gmfbo.errors import TwinFileError
from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.study_remarks import study_remarks, unmet_of_recommended
from gmfbo.tuning.tuner import Tuner
from tests.pages.page_text import PageText
from tests.tuning.linear_study import linear_study

LIMIT = "[objective]\nnormalise = 4\n[constraints]\nphase_margin = {limit}\n"


def test_no_gains_beyond_the_margin_are_run_on_the_axis_after_the_initial_ones(
    tmp_path: Path,
) -> None:
    free = linear_study(tmp_path / "free", LIMIT.format(limit=1.0), method="random", iterations=0)
    with Tuner(free) as tuner:
        tuner.run()
    known = sorted(t.metrics["phase_margin"] for t in free.trials if t.source == "IS2")
    limit = known[len(known) // 2]  # half of the box is too lively
    study = linear_study(tmp_path, LIMIT.format(limit=limit), method="random", iterations=6)
    with Tuner(study) as tuner:
        tuner.run()
    real = [trial for trial in study.trials if trial.source == "IS1"]
    assert all(trial.metrics["phase_margin"] >= limit for trial in real[2:])
    asked = [trial for trial in study.trials if trial.source == "IS2" and trial.parent is None]
    withheld = asked[10:]
    assert withheld  # control: the random method did propose some
    assert all(trial.metrics["phase_margin"] < limit for trial in withheld)


def test_a_margin_without_a_command_port_is_refused(tmp_path: Path) -> None:
    study = linear_study(tmp_path, LIMIT.format(limit=45.0))
    twin = tmp_path / "twin.toml"
    text = (study.origin / "linear.toml").read_text(encoding="utf-8")
    source = Path(text.partition('twin = "')[2].partition('"')[0])
    without = source.read_text(encoding="utf-8").replace('command = "port.command"\n', "")
    twin.write_text(
        without.replace('fmu = "', f'fmu = "{source.parent.as_posix()}/'), encoding="utf-8"
    )
    changed = text.replace(source.as_posix(), twin.as_posix())
    (study.origin / "linear.toml").write_text(changed, encoding="utf-8")
    with pytest.raises(TwinFileError, match="port 'command'"):
        Tuner(type(study).read(study.origin / "linear.toml"))


def test_a_limit_that_nothing_meets_is_told_wherever_gains_are_recommended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = linear_study(tmp_path, LIMIT.format(limit=175.0), method="random", iterations=3)
    path = study.origin / "linear.toml"
    path.write_text(path.read_text(encoding="utf-8") + "is1_runs = 6\n", encoding="utf-8")
    study = type(study).read(path)
    with Tuner(study) as tuner:
        result = tuner.run()
    screen = Console(file=io.StringIO(), width=200)
    monkeypatch.setattr(study_result, "console", screen)
    study_result.print_result(study, result)
    printed = " ".join(screen.file.getvalue().split())  # type: ignore[attr-defined]
    (missed,) = result.unmet
    # Between the gains and what is expected of them.
    assert missed in printed.partition("recommended ")[2].partition(" expected ")[0]
    assert missed.startswith("does not meet the limit phase margin >= 175: ")
    assert missed.endswith(" deg (from the twin)")
    assert "only 2 of 6 real runs were made: no query is left (iterations = 3," in printed
    review = StudyReview.read(study.location)
    page = study_page(review)
    text = " ".join(PageText(page).text)
    assert missed in text
    assert unmet_of_recommended(review) == (missed,)
    assert page.count('<th scope="row">phase margin [deg] (from the twin)</th>') == 1
    assert page.count("<th class=number>phase margin [deg] (from the twin)</th>") == 2
    assert result.remarks == study_remarks(review)
    assert review.space == tuner.gains.space  # the twin file's box, which the log holds
