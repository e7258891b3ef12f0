"""A run that never settles is neither best nor recommended while one that settles is there."""

from __future__ import annotations

import pytest

from gmfbo import Study
from tests.cases.case_folder import CaseFolder, needs_case

CASE = "21-unstable-gains-win"
pytestmark = [needs_case(CASE), pytest.mark.slow]


@pytest.mark.parametrize("seed", [2, 3])
def test_a_settled_run_wins(case: CaseFolder, seed: int) -> None:
    answer = case.gmfbo(f"tune u{seed}.toml")
    assert answer.code == 0
    study = Study.read(case.path / f"u{seed}.study")
    real = [trial for trial in study.trials if trial.source == "IS1"]
    # One of the first runs is unstable, and has the smaller objective by its rise time.
    unstable = [trial for trial in real if trial.metrics["overshoot"] > 300.0]
    assert unstable
    assert study.best is not None
    assert study.best.metrics["settling_time"] < 0.8
    assert study.best.metrics["overshoot"] < 25.0
    assert study.recommendation is not None
    kp = study.recommendation.gains["kp"]
    assert any(t.gains["kp"] == kp and t.metrics["settling_time"] < 0.8 for t in real)
    # Negative control: by the objective alone the unstable run would beat another that settled.
    settled = [trial for trial in real if (trial.late_error or 0.0) <= 1.0]
    assert max(t.objective for t in settled) > min(t.objective for t in unstable)


def test_where_no_run_settles_that_comes_first_and_nothing_is_recommended(
    case: CaseFolder,
) -> None:
    answer = case.gmfbo("tune pendulum.toml")
    assert answer.code == 0
    assert "no real run settled (of 4), so no gains are recommended" in answer.out
    assert answer.out.index("no real run settled") < answer.out.index("least bad")
    assert "recommended " not in answer.out.partition("least bad run")[2]
    assert Study.read(case.path / "s.study").recommendation is None


def test_the_published_method_prices_as_its_paper_does(case: CaseFolder) -> None:
    text = (case.path / "u3.toml").read_text(encoding="utf-8")
    text = text.replace("[budget]\nis1_runs = 12", "as_published = true").replace(
        "horizon = 0.8", "horizon = 0.8\n[budget]\nis1_runs = 2\n[objective]"
    )
    (case.path / "paper.toml").write_text(text.replace('"u3"', '"paper"'), encoding="utf-8")
    assert case.gmfbo("tune paper.toml").code == 0
    best = Study.read(case.path / "paper.study").best
    assert best is not None
    assert best.metrics["overshoot"] > 300.0
    assert best.late_error is None
