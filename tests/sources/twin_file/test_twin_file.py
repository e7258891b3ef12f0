"""What a twin file may say, and the one line that each mistake gives."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from gmfbo.errors import TwinFileError
from gmfbo.sources.twin_file.twin_file import GainRange, TwinFile

COMPLETE = """
name = "AX7 servo axis"
fmu = "ax7.fmu"
step = 1e-3
warmup = 0.5
[inputs]
reference = "ref.phi"
current = { variable = "drive.iq", column = "iq_mA", scale = 1e-3, interpolation = "linear" }
[outputs]
position = { variable = "enc.phi", column = "pos_counts", scale = 1.533981e-3, offset = "fit" }
[outputs.torque_command]
variable = "ctl.tauCmd"
scale = "mot.kt"
uncertain_scale = 0.03
logged = "held"
shift_range = [-2e-3, 2e-3]
[parameters]
"mot.tauMax" = 60.0
"mot.on" = true
[gains]
"ctl.Kp" = [30.0, 200.0]
"ctl.Kd" = { low = 0.1, high = 10.0, scale = "log" }
"ctl.n" = { low = 1, high = 8, integer = true }
"ctl.Ki" = 3.0
[uncertain]
"mech.J" = [0.06, 0.24]
[ports]
torque = "dist.tau"
[states]
position = "enc.phi"
[roles]
inertia = "mech.J"
[initial]
"mech.phi0" = "position"
"mech.w0" = 0.0
"mech.x0" = "fit"
"""

MINIMAL = 'name = "a"\nfmu = "a.fmu"\nstep = 1e-3\n[outputs]\ny = "y"\n'


def parse(text: str) -> TwinFile:
    return TwinFile.parse(text, "ax7.toml")


def test_every_table_of_the_format_is_understood() -> None:
    twin = parse(COMPLETE)
    assert twin.warmup == 0.5
    assert twin.inputs["reference"].variable == "ref.phi"
    assert twin.inputs["reference"].interpolation == "hold"
    assert twin.inputs["current"].interpolation == "linear"
    assert twin.inputs["current"].scale == 1e-3
    assert twin.outputs["position"].offset == "fit"
    assert twin.outputs["position"].logged == "unknown"
    assert twin.outputs["torque_command"].scale == "mot.kt"
    assert twin.outputs["torque_command"].shift_range == (-2e-3, 2e-3)
    assert twin.parameters == {"mot.tauMax": 60.0, "mot.on": 1.0}
    assert twin.uncertain == {"mech.J": (0.06, 0.24)}
    assert twin.initial == {"mech.phi0": "position", "mech.w0": 0.0, "mech.x0": "fit"}


def test_gains_are_ranges_log_ranges_integers_or_fixed() -> None:
    gains = parse(COMPLETE).gains
    assert gains["ctl.Kp"] == GainRange(low=30.0, high=200.0)
    assert gains["ctl.Kd"].scale == "log"
    assert gains["ctl.n"].integer
    assert gains["ctl.Ki"].fixed
    assert not gains["ctl.Kp"].fixed


def test_fmus_are_paths_or_our_own_controllers() -> None:
    twin = parse(
        'name = "a"\nstep = 1e-3\n[fmus]\nc = { kind = "pid", sample_time = 1e-3, ki = 2 }\n'
        'p = "p.fmu"\n[wires]\n"p.tau" = "c.u"\n[outputs]\ny = "p.w"\n'
    )
    controller = twin.fmus["c"]
    assert not isinstance(controller, str)
    assert controller.settings == {"sample_time": 1e-3, "ki": 2}
    assert list(twin.fmus) == ["c", "p"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "name = 'a'\nstep = = 1",
            "ax7.toml: not valid TOML: Invalid value (at line 2, column 8)",
        ),
        (
            MINIMAL.replace("1e-3", "'1e-3'"),
            "ax7.toml: step: expected number, got '1e-3'",
        ),
        (MINIMAL.replace("step", "stepp"), "unknown key 'stepp'; did you mean 'step'?"),
        (MINIMAL.replace("step = 1e-3\n", ""), "ax7.toml: 'step' is missing"),
        (
            MINIMAL.replace("1e-3", "-1e-3"),
            "ax7.toml: step: expected greater than 0, got -0.001",
        ),
        (
            "stop_time = 'end'\n" + MINIMAL,
            "ax7.toml: stop_time: expected true, false or a number of seconds, got 'end'",
        ),
        (
            "stop_time = inf\n" + MINIMAL,
            "ax7.toml: stop_time: expected true, false or a number of seconds, got inf",
        ),
        (MINIMAL.replace("1e-3", "'fast'"), "ax7.toml: step: expected number, got 'fast'"),
        (
            MINIMAL.replace("1e-3", "inf"),
            "ax7.toml: step: expected a finite number, got inf",
        ),
        (
            MINIMAL.replace('fmu = "a.fmu"\n', ""),
            "ax7.toml: expected either fmu = FILE or a table [fmus]",
        ),
        (
            MINIMAL + "[wires]\n'a' = 'b'\n",
            "ax7.toml: [wires] joins the FMUs of [fmus]; with fmu = FILE there is none",
        ),
        (
            MINIMAL + "[outputs.z]\nvariable = 'z'\nlogged = 'old'\n",
            "ax7.toml: [outputs] 'z' logged: expected 'held', 'new' or 'unknown', got 'old'",
        ),
        (
            MINIMAL + "[outputs.z]\nvariable = 'z'\ncolum = 'c'\n",
            "ax7.toml: [outputs] 'z': unknown key 'colum'; did you mean 'column'?",
        ),
        (
            MINIMAL + "[inputs]\ny = 'u'\n",
            "ax7.toml: signal 'y' is in [inputs] and in [outputs]; rename one",
        ),
        (
            MINIMAL + "[gains]\nk = [3.0, 1.0]\n",
            "ax7.toml: [gains] 'k': expected low <= high, got [3, 1]",
        ),
        (
            MINIMAL + "[gains]\nk = [3.0]\n",
            "ax7.toml: [gains] 'k': expected [low, high], got [3.0]",
        ),
        (
            MINIMAL + "[gains]\nk = { low = 0.0, high = 1.0, scale = 'log' }\n",
            "ax7.toml: [gains] 'k': a log scale needs a positive lower bound, got 0",
        ),
        (
            MINIMAL + "[uncertain]\nJ = [3.0, 1.0]\n",
            "ax7.toml: [uncertain] 'J': expected [low, high] with low < high, got [3.0, 1.0]",
        ),
        (
            MINIMAL + "[states]\nspeed = 'w'\n",
            "ax7.toml: states: no state 'speed'",
        ),
        (
            MINIMAL + "[parameters]\nJ = [1.0]\n",
            "ax7.toml: [parameters] 'J': expected number, got [1.0]",
        ),
        (
            MINIMAL.replace('fmu = "a.fmu"\n', "") + "[fmus]\nc = { kind = 'pdi' }\n",
            "ax7.toml: fmus: c: no controller kind 'pdi'; did you mean 'pid'?",
        ),
        (
            MINIMAL.replace('fmu = "a.fmu"\n', "") + "[fmus]\n'c.d' = 'x.fmu'\n",
            "ax7.toml: fmus: 'c.d': expected a prefix without a dot",
        ),
        (
            'name = "a"\nfmu = "a.fmu"\nstep = 1e-3\n[outputs]\n',
            "ax7.toml: [outputs]: expected at least one signal to compare",
        ),
    ],
)
def test_a_mistake_gives_one_line_with_file_and_key(text: str, message: str) -> None:
    with pytest.raises(TwinFileError, match=re.escape(message)) as caught:
        parse(text)
    assert "\n" not in str(caught.value)
    assert "pydantic" not in str(caught.value)


def test_the_first_three_of_several_mistakes_are_told() -> None:
    text = MINIMAL.replace("step = 1e-3", "step = 0.0\nwarmup = -1.0\na = 1\nb = 2\nc = 3")
    with pytest.raises(TwinFileError, match="step: expected greater than 0, got 0") as caught:
        parse(text)
    assert str(caught.value).count("; ") >= 3
    assert str(caught.value).endswith("; and 2 more")


def test_a_missing_file_and_a_binary_file_are_one_line_each(tmp_path: Path) -> None:
    with pytest.raises(TwinFileError, match=r"no twin file at '.*none\.toml' \(No such file"):
        TwinFile.read(tmp_path / "none.toml")
    (tmp_path / "model.fmu").write_bytes(b"PK\x03\x04\xff\xfe")
    with pytest.raises(TwinFileError, match=r"model\.fmu: expected UTF-8 text; is it an FMU\?"):
        TwinFile.read(tmp_path / "model.fmu")


@pytest.mark.parametrize("module", ["twin_file", "worker", "twin", "inspection"])
def test_reading_and_running_twins_loads_no_torch_and_no_scipy(module: str) -> None:
    code = (
        f"import sys, gmfbo.sources.{module}; "
        "print([m for m in ('torch', 'scipy', 'h5py') if m in sys.modules])"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == "[]"
