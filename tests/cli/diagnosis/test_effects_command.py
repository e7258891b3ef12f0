"""`gmfbo effects`: all laws in short, one in full, those of packages too."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gmfbo.cli import main
from gmfbo.physics import CATALOGUE, add_effect
from gmfbo.plain_words import WIDTH


def test_all_laws_are_listed_with_law_sentence_and_needs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["effects"]) == 0
    shown = capsys.readouterr().out
    lines = shown.splitlines()
    assert [line for line in lines if not line.startswith(" ")] == [*CATALOGUE]
    assert max(map(len, lines)) <= WIDTH
    told = " ".join(shown.split())
    for effect in CATALOGUE.values():
        assert effect.equation in told
    assert "Coulomb friction of about 0.7 N m at the motor shaft is missing from the twin." in told
    assert "needs a port 'command' under [ports], [states] command or current and" in told


def test_one_law_is_told_in_full(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "backlash"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert told.startswith("backlash law tau = -k * deadzone(")
    assert "gap [rad]: Effective gap, total free play" in told
    assert "hysteresis; told apart by fast reversals" in told
    assert told.endswith("source Nordin and Gutman, 2002")


def test_a_law_of_a_package_is_listed_last_and_marked(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(CATALOGUE, "_added", {})
    monkeypatch.setattr(CATALOGUE, "_loaded", True)
    assert main(["effects"]) == 0
    assert "added" not in capsys.readouterr().out  # control
    own = replace(CATALOGUE["elastic_return"], name="bellows", contains=(), as_limit={})
    add_effect(own)
    assert main(["effects"]) == 0
    shown = capsys.readouterr().out
    last = [line for line in shown.splitlines() if not line.startswith(" ")][-1]
    assert last == "bellows"
    assert "added by a package; its law is in the FMU that GMFBO_PHYSICS" in shown


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("colomb_friction", "no effect 'colomb_friction'; did you mean 'coulomb_friction'?"),
        ("zzz", "no effect 'zzz'; known are actuator_dead_zone"),
    ],
)
def test_a_name_that_is_no_effect_gets_one_line(
    name: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["effects", name]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert said in told
