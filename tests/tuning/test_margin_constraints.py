"""A study with a limit on a margin: measured on the twin, and kept from the axis."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo.errors import TwinFileError
from gmfbo.tuning.tuner import Tuner
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
