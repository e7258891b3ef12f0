"""Any number of failed real runs: the study goes on, or ends with the reason."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "20-five-failed-runs"
pytestmark = [needs_case(CASE), pytest.mark.slow]


def test_a_program_that_always_fails_ends_the_study_with_its_reason(case: CaseFolder) -> None:
    for command in ("tune s.toml --random-start", "tune s.toml --resume"):
        answer = case.gmfbo(command)
        assert answer.code == 3
        assert answer.err.startswith("gmfbo: no real run succeeded: all 7 failed")
        assert "drive not ready" in answer.err


def test_without_a_terminal_a_random_start_has_to_be_allowed(case: CaseFolder) -> None:
    answer = case.gmfbo("tune s.toml")
    assert answer.code == 2
    assert "--random-start" in answer.err
    assert not (case.path / "s.study").exists()


def test_five_runs_told_as_failed_are_followed_by_a_sixth(case: CaseFolder) -> None:
    for _ in range(5):
        assert case.gmfbo("ask t.toml --random-start").code == 0
        assert case.gmfbo("tell t.toml --failed unstable").code == 0
    answer = case.gmfbo("ask t.toml")
    assert answer.code == 0
    assert "real run 6 of 7" in answer.out


def test_a_study_whose_runs_all_leave_the_envelope_ends(case: CaseFolder) -> None:
    answer = case.gmfbo("tune safety.toml")
    assert answer.code == 3
    assert "left the safety envelope" in answer.err


def test_negative_control_a_program_that_fails_at_soft_gains_only_is_tuned(
    case: CaseFolder,
) -> None:
    program = (
        "import sys, csv, math\n"
        "kp = float(sys.argv[2].split('=')[1])\n"
        "if kp < 120: sys.exit('too soft')\n"
        "named = dict(zip(sys.argv, sys.argv[1:]))\n"
        "rows = [r for r in csv.reader(open(named['--reference'])) if not r[0].startswith('#')]\n"
        "with open(named['--out'], 'w') as out:\n"
        "    out.write('time [s],position [rad]\\n')\n"
        "    for t, r in rows[1:]:\n"
        "        y = 1 - math.exp(-max(0, float(t) - 0.1) * kp / 4)\n"
        "        out.write(f'{t},{y!r}\\n')\n"
    )
    (case.path / "soft.py").write_text(program, encoding="utf-8")
    text = (case.path / "s.toml").read_text(encoding="utf-8")
    line = next(line for line in text.splitlines() if line.startswith("command"))
    text = text.replace(line, 'command = ["python3", "soft.py"]').replace('"s"', '"soft"')
    (case.path / "soft.toml").write_text(text, encoding="utf-8")
    answer = case.gmfbo("tune soft.toml --random-start")
    assert answer.code == 0, answer.err
    assert "recommended" in answer.out
