"""Habits of vendors' FMUs, each with an FMU of our own that has it."""

from __future__ import annotations

import platform
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording, models_folder, write_recording
from gmfbo.cli import main
from gmfbo.errors import FmuFileError, InputError, TwinFileError
from gmfbo.sources.fmu_file.description import read_description
from gmfbo.sources.inspection.inspection import inspect_fmu, starting_twin_file
from gmfbo.sources.twin_file.twin_file import TwinFile
from tests.sources.kinds.conftest import compiled

if TYPE_CHECKING:
    from tests.sources.kinds.conftest import Make

RAMP = Recording(
    time=1e-3 * np.arange(11.0), signals={"reference": 0.5 + 0.1 * np.arange(11, dtype=np.float64)}
)
pytestmark = pytest.mark.skipif(platform.machine() != "x86_64", reason="folders are of x86-64")


def last(twin: Path, signal: str, **parameters: float | str) -> float:
    with FmuTwin(twin) as source:
        run = source.run({}, RAMP, parameters=parameters)
        assert run.status == "ok", run.message
        return float(run.signal(signal)[-1])


@pytest.mark.parametrize("fmi", [2, 3])
def test_parameters_are_given_in_the_words_of_their_type(small: Make, fmi: int) -> None:
    given = '[parameters]\n"file" = "a long name.txt"\n"mode" = "Torque"\n"enable" = true\n'
    twin = small(fmi=fmi, end=given)
    assert last(twin, "length") == 15 + 500
    assert last(twin, "length", file="=", mode="Speed") == 1 + 200
    assert last(twin, "position", enable="false") == 0.0
    assert last(twin, "position", gain="2") == pytest.approx(2 * RAMP.signal("reference")[-2])


def test_a_twin_without_words_leaves_the_fmus_own(small: Make) -> None:
    """Negative control: the text that the FMU starts with has five letters."""
    assert last(small(), "length") == 5


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"mode": 3.0}, "parameter 'mode': expected one of Position=1, Speed=2, Torque=5, got 3"),
        ({"mode": "Off"}, "expected one of Position=1, Speed=2, Torque=5, got 'Off'"),
        ({"enable": "yes"}, r"expected a Boolean: true or false \(1 or 0\), got 'yes'"),
        ({"gain": "much"}, "parameter 'gain': expected a number, got 'much'"),
        ({"file": 3.0}, "parameter 'file': expected a text in quotes, got 3"),
        ({"fiel": "x"}, "no FMU parameter 'fiel'; did you mean 'file'"),
    ],
)
def test_a_word_that_is_none_of_the_type_is_refused(
    small: Make, given: dict[str, float | str], says: str
) -> None:
    with FmuTwin(small()) as twin, pytest.raises(InputError, match=says):
        twin.run({}, RAMP, parameters=given)


def test_a_wrong_word_in_the_twin_file_is_told_with_its_table(small: Make) -> None:
    with pytest.raises(
        TwinFileError, match=r"twin.toml: \[parameters\] parameter 'mode': expected"
    ):
        FmuTwin(small(end='[parameters]\n"mode" = "Off"\n'))


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_twin_file_to_start_from_names_words(small: Make, fmi: int) -> None:
    folder = small(fmi=fmi).parent
    text = starting_twin_file(inspect_fmu(folder / "small.fmu"))
    assert '# "file" = "short"' in text
    assert '# "mode" = "Position"  # one of Position=1, Speed=2, Torque=5' in text
    assert '# "enable" = true' in text
    loaded = TwinFile.parse(text.replace('# "file"', '"file"').replace('# "mode"', '"mode"'), "a")
    assert loaded.words == {"file": "short", "mode": "Position"}


def test_the_end_of_the_run_is_announced_where_the_twin_file_says_so(small: Make) -> None:
    with FmuTwin(small("NEEDS_STOP")) as twin:
        refused = twin.run({}, RAMP)
    assert refused.status == "failed"
    assert "no End Time was given" in refused.message
    assert "put 'stop_time = true' above the tables of the twin file" in refused.message
    # The FMU takes the stop time as its gain.
    twin_file = small("NEEDS_STOP", top="stop_time = true\n")
    assert last(twin_file, "position") == pytest.approx(0.011 * RAMP.signal("reference")[-2])
    twin_file = small("NEEDS_STOP", top="stop_time = 7.0\n")
    assert last(twin_file, "position") == pytest.approx(7.0 * RAMP.signal("reference")[-2])


@pytest.mark.parametrize("habits", [("NEEDS_STOP",), ()], ids=["asks", "does not"])
def test_a_first_twin_file_announces_the_end_where_the_fmu_wants_it(
    small: Make, habits: tuple[str, ...], tmp_path: Path
) -> None:
    fmu = small(*habits).parent / "small.fmu"
    write_recording(RAMP.with_signals({"position": RAMP.signal("reference")}), tmp_path / "log.csv")
    assert main(["init", str(fmu), str(tmp_path / "log.csv"), "--out", str(tmp_path / "axis")]) == 0
    text = (tmp_path / "axis" / "twin.toml").read_text(encoding="utf-8")
    assert ("stop_time = true  # the FMU refused to run without it" in text) is bool(habits)


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_hang_names_the_call_and_the_line_that_gives_more_time(small: Make, fmi: int) -> None:
    with FmuTwin(small("HANG", fmi=fmi, top="time_limit = 0.5\n")) as twin:
        run = twin.run({}, RAMP)
    assert run.status == "timeout"
    assert "did not finish within 0.5 s, stopped while stepping" in run.message
    assert f"(fmi{fmi}DoStep, or setting or reading values)" in run.message
    assert "raise time_limit in the twin file if it is slow" in run.message


@pytest.mark.parametrize(
    "words", ["socket: Operation not permitted", "Licence server does not answer", "fork failed"]
)
def test_what_the_sandbox_may_have_refused_is_told_with_the_switch(
    small: Make, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    twin_file = small(f'LICENCE="{words}"')
    with FmuTwin(twin_file) as twin:
        run = twin.run({}, RAMP)
    assert "gmfbo shuts FMUs in" in run.message
    assert "GMFBO_SANDBOX=network lets it open connections" in run.message
    monkeypatch.setenv("GMFBO_SANDBOX", "off")
    with FmuTwin(twin_file) as twin:
        assert "GMFBO_SANDBOX" not in twin.run({}, RAMP).message


def test_an_fmu_that_fails_for_another_reason_is_not_told_of_the_sandbox(small: Make) -> None:
    with FmuTwin(small('LICENCE="inertia must be positive"')) as twin:
        run = twin.run({}, RAMP)
    assert "inertia must be positive" in run.message
    assert "gmfbo shuts FMUs in" not in run.message


def test_libraries_beside_the_fmus_own_are_found(small: Make, tmp_path: Path) -> None:
    """One needs the next, and neither library has a search path."""
    inner, outer = tmp_path / "inner.c", tmp_path / "outer.c"
    inner.write_text("double inner(void) { return 3.0; }\n")
    outer.write_text(
        "double inner(void); double gain_of_the_library_beside(void) { return inner(); }\n"
    )
    first = compiled(tmp_path, "libinner.so", inner, ["-Wl,-soname,libinner.so"])
    second = compiled(tmp_path, "libouter.so", outer, ["-Wl,-soname,libouter.so", str(first)])
    twin = small("BESIDE", beside=[second, first])
    assert last(twin, "position") == pytest.approx(3.0 * RAMP.signal("reference")[-2])


def test_a_library_that_is_not_there_is_still_named(small: Make, tmp_path: Path) -> None:
    source = tmp_path / "outer.c"
    source.write_text("double gain_of_the_library_beside(void) { return 1.0; }\n")
    library = compiled(tmp_path, "libouter.so", source, ["-Wl,-soname,libouter.so"])
    twin_file = small("BESIDE", beside=[library])
    fmu = twin_file.with_name("small.fmu")
    with zipfile.ZipFile(fmu) as archive:
        kept = {n: archive.read(n) for n in archive.namelist() if "libouter" not in n}
    with zipfile.ZipFile(fmu, "w") as archive:
        for name, content in kept.items():
            archive.writestr(name, content)
    with FmuTwin(twin_file) as twin, pytest.raises(FmuFileError, match=r"needs .*libouter\.so"):
        twin.run({}, RAMP)


def repacked(source: Path, target: Path, rename: dict[str, str]) -> Path:
    """An FMU whose members begin otherwise; an empty beginning leaves them out."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            renamed = name
            for start, other in rename.items():
                if name.startswith(start):
                    renamed = name.replace(start, other).replace("/", "\\") if other else ""
            if renamed:
                info = zipfile.ZipInfo("x")
                info.filename = renamed
                new.writestr(info, old.read(name))
    return target


def test_an_archive_with_backslashes_runs(tmp_path: Path) -> None:
    fmu = repacked(
        models_folder() / "servo_axis.fmu", tmp_path / "a.fmu", {"binaries/": "binaries/"}
    )
    assert any("\\" in name for name in zipfile.ZipFile(fmu).NameToInfo)
    description = read_description(fmu)
    assert "linux64" in description.platforms
    text = (models_folder() / "servo_axis.toml").read_text(encoding="utf-8")
    twins = []
    for name in ("a.fmu", (models_folder() / "servo_axis.fmu").as_posix()):
        path = tmp_path / "twin.toml"
        path.write_text(text.replace('"servo_axis.fmu"', f'"{name}"'), encoding="utf-8")
        with FmuTwin(path) as twin:
            twins.append(twin.run({}, RAMP).signal("position"))
    np.testing.assert_array_equal(twins[0], twins[1])


def test_an_fmu_with_c_sources_only_is_refused_in_a_line(tmp_path: Path) -> None:
    fmu = repacked(models_folder() / "servo_axis.fmu", tmp_path / "a.fmu", {"binaries/": ""})
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr("sources/all.c", "int x;\n")
    with pytest.raises(FmuFileError, match="it has C sources only, which gmfbo does not compile"):
        read_description(fmu).library()


ARRAY_TWIN = """
name = "small"
fmu = "small.fmu"
step = 1e-3
[inputs]
upper = "reference[1,2]"
lower = "reference[2,1]"
[outputs]
a = "position[1,1]"
b = "position[1,2]"
c = "position[2,1]"
d = "position[2,2]"
"""


def test_elements_of_arrays_are_variables_row_by_row(small: Make) -> None:
    twin_file = small("ARRAYS", fmi=3)
    twin_file.write_text(ARRAY_TWIN, encoding="utf-8")
    time = 1e-3 * np.arange(6.0)
    signals = {"upper": 1.0 + np.arange(6.0), "lower": 10.0 * np.arange(6.0)}
    both = Recording(time=time, signals=signals)
    with FmuTwin(twin_file) as twin:
        own = twin.run({}, both)
        set_ = twin.run({}, both, parameters={"gain[2,2]": 7.0})
        half = twin.run({}, Recording(time=time, signals={"upper": signals["upper"]}))
    assert own.status == set_.status == "ok", own.message + set_.message
    # Row k + 1 holds what the inputs of row k make; an element that nothing drives stays.
    np.testing.assert_array_equal(own.signal("a")[1:], 0.0)
    np.testing.assert_array_equal(own.signal("b")[1:], 2.0 * signals["upper"][:-1])
    np.testing.assert_array_equal(own.signal("c")[1:], 3.0 * signals["lower"][:-1])
    np.testing.assert_array_equal(half.signal("c")[1:], 0.0)
    np.testing.assert_array_equal(half.signal("b"), own.signal("b"))
    np.testing.assert_array_equal(set_.signal("b"), own.signal("b"))


def test_a_schedule_may_move_one_element(small: Make) -> None:
    twin_file = small("ARRAYS", fmi=3)
    twin_file.write_text(ARRAY_TWIN, encoding="utf-8")
    time = 1e-3 * np.arange(6.0)
    moved = np.array([3.0, 3.0, 3.0, 9.0, 9.0, 9.0])
    run = Recording(time=time, signals={"lower": np.full(6, 10.0)}, schedules={"gain[2,1]": moved})
    with FmuTwin(twin_file) as twin:
        np.testing.assert_array_equal(twin.run({}, run).signal("c")[1:], 10.0 * moved[:-1])


def test_a_twin_file_to_start_from_names_the_elements(small: Make) -> None:
    folder = small("ARRAYS", fmi=3).parent
    report = inspect_fmu(folder / "small.fmu")
    text = starting_twin_file(report)
    assert TwinFile.parse(text, "a").outputs["position_2_1"].variable == "position[2,1]"
    assert '# "gain[1,2]" = 2.0' in text
    (folder / "own.toml").write_text(text, encoding="utf-8")
    with FmuTwin(folder / "own.toml") as twin:
        assert twin.nominal("gain[2,2]") == 4.0


def test_an_array_whose_size_is_a_parameter_is_refused_by_name(small: Make) -> None:
    twin_file = small("ARRAYS", fmi=3)
    text = ARRAY_TWIN.replace('d = "position[2,2]"', 'd = "of_a_size"')
    twin_file.write_text(text, encoding="utf-8")
    with pytest.raises(TwinFileError, match="'of_a_size' is an array of 2; ask its vendor"):
        FmuTwin(twin_file)
