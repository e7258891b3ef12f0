"""Rows 19 to 27 ms apart, and a CAN log of 1 ms +- 0.3 ms."""

from __future__ import annotations

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "10-jittering-clock"
pytestmark = needs_case(CASE)
SAID = "the twin runs at its own step, inputs are held, each signal is compared at its own instants"


def with_servo(case: CaseFolder, top: str = "", end: str = "") -> None:
    text = (case.path / "../servo.toml").read_text(encoding="utf-8")
    (case.path / "twin.toml").write_text(top + text + end, encoding="utf-8")


def test_a_log_of_a_vesc_is_mapped_saved_and_compared(case: CaseFolder) -> None:
    command = "columns ../servo.toml vesc.csv --set time=ms_today[ms] --save m.toml"
    answer = case.gmfbo(f"{command} --set torque_command=current_motor")
    assert answer.code == 0, answer.err
    assert f"rows come 0.019 to 0.027 s apart: {SAID}" in answer.out
    with_servo(case, 'columns = "m.toml"\n')
    told = case.gmfbo("simulate twin.toml --reference vesc.csv --out s.csv")
    assert told.code == 0, told.err
    assert SAID in told.out
    assert "position" in told.out


def test_a_can_log_of_the_twin_itself_agrees(case: CaseFolder) -> None:
    with_servo(case)
    told = case.gmfbo("simulate twin.toml --reference canjitter.mf4 --out s.csv")
    assert told.code == 0, told.err
    assert SAID in told.out
    nrmse = float(told.out.partition("position ")[2].split()[0])
    assert nrmse < 0.1  # percent


def test_it_is_resampled_on_request(case: CaseFolder) -> None:
    with_servo(case, end="[recording]\nresample = 1e-3\n")
    told = case.gmfbo("simulate twin.toml --reference canjitter.mf4 --out s.csv")
    assert told.code == 0, told.err
    assert "canjitter.mf4: resampled to a row each 0.001 s, as stated" in told.out
    assert SAID not in told.out


def test_the_preset_of_a_vesc_fills_the_mapping(case: CaseFolder) -> None:
    answer = case.gmfbo("columns ../servo.toml vesc.csv --preset vesc")
    assert answer.code == 0, answer.err
    assert "preset vesc, by https://github.com/vedderb/vesc_tool" in answer.out
    assert "5.2452e+07 time" in answer.out
