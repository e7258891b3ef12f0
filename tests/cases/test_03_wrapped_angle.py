"""A position that the logger wraps gives the verdict of one that it does not."""

from __future__ import annotations

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "03-wrapped-angle"
pytestmark = needs_case(CASE)
NOTE = "position jumps by a full turn: it wraps; unwrapped"


def test_simulate_unwraps_with_a_note(case: CaseFolder) -> None:
    wrapped = case.gmfbo("simulate ../servo.toml --reference wr0.csv --out s.csv")
    assert f"! wr0.csv: {NOTE}" in wrapped.out
    plain = case.gmfbo("simulate ../servo.toml --reference ok0.csv --out t.csv")
    assert "wraps" not in plain.out
    assert wrapped.out.partition("signal")[2] == plain.out.partition("signal")[2]


def test_check_sees_nothing_wrong_but_the_wrap(case: CaseFolder) -> None:
    answer = case.gmfbo("check ../servo.toml wr0.csv wr1.csv wr2.csv")
    first = "servo axis: 3 recordings, nothing wrong with them was seen"
    notes = " ".join(f"note: wr{k}.csv: {NOTE}" for k in range(3))
    assert answer.out.startswith(f"{first} {notes}")


def test_diagnose_gives_the_true_inertia_where_both_wrap_in_degrees(case: CaseFolder) -> None:
    answer = case.gmfbo("diagnose ../servo.toml wrap.csv wrap.csv --out d")
    assert answer.code == 0
    found = case.json("d/diagnosis.json")
    assert found["verdict"] == "none"
    inertia = found["parameters"]["inertia"]
    assert inertia["low"] <= 0.01 <= inertia["high"]
    assert f"wrap.csv: {NOTE}" in found["notes"]


def test_wrapped_false_leaves_the_jumps(case: CaseFolder) -> None:
    file = case.path.parent / "servo.toml"
    text = file.read_text().replace(
        'position = "position"\ntorque',
        'position = { variable = "position", wrapped = false }\ntorque',
    )
    file.write_text(text)
    answer = case.gmfbo("simulate ../servo.toml --reference wr0.csv --out s.csv")
    assert "unwrapped" not in answer.out
    assert "58.71 %" in answer.out
