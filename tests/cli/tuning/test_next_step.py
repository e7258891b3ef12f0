"""At the end of a study the command stands that asks its runs what the twin lacks."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from gmfbo.cli import main
from gmfbo.sources.fmu_file.models import models_folder

STUDY = """
method = "random"
[is1]
twin = "servo_axis.toml"
[is2]
twin = "servo_axis.toml"
[objective]
normalise = 2
[budget]
initial_is1 = {runs}
initial_is2 = 2
is1_runs = {runs}
"""


@pytest.mark.parametrize(("runs", "ports", "told"), [(2, True, 1), (1, True, 0), (2, False, 0)])
def test_the_command_is_there_where_a_diagnosis_can_say_something(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], runs: int, ports: bool, told: int
) -> None:
    text = (models_folder() / "servo_axis.toml").read_text(encoding="utf-8")
    if not ports:
        head, _, rest = text.partition("[ports]")
        text = head + rest.partition("\n\n")[2]
    (tmp_path / "servo_axis.toml").write_text(text, encoding="utf-8")
    shutil.copy(models_folder() / "servo_axis.fmu", tmp_path)
    (tmp_path / "joint.toml").write_text(STUDY.format(runs=runs), encoding="utf-8")
    assert main(["tune", str(tmp_path / "joint.toml")]) == 0
    said = capsys.readouterr().out
    assert said.count("gmfbo diagnose") == told
    if told:
        assert "joint.study --out" in " ".join(said.split())
