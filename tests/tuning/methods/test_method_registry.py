"""Methods of other packages: found by their entry point, checked, and run by the same loop."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo.cli import main
from gmfbo.errors import InputError
from gmfbo.tuning.methods import METHODS, all_methods, find_method
from gmfbo.tuning.study_file.study_sections import DEFAULT_METHOD
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study

CORNER = """
import numpy as np
from gmfbo.tuning.query.method import Proposal


class Corner:
    name = "corner"
    summary = "walks from the upper corner"
    reference = "a test, 2026"
    correction = None

    def propose(self, state, rng):
        return Proposal("IS1", np.full(len(state.space), 1.0 - 0.1 * len(state.of("IS1"))))

    def recommend(self, state):
        best = min(state.of("IS1"), key=lambda seen: seen.objective)
        return best.point, best.objective, 0.0
"""


def install(folder: Path, module: str, text: str, entry: str) -> None:
    """A package as an installer leaves it: a module, and what it offers under which name."""
    (folder / f"{module}.py").write_text(text, encoding="utf-8")
    about = folder / f"{module}-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[gmfbo.methods]\n{entry}\n")


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)
    return folder


def test_a_package_adds_a_method_that_the_loop_runs(packages: Path, tmp_path: Path) -> None:
    install(packages, "corner_search", CORNER, "corner = corner_search:Corner")
    study = write_study(tmp_path / "study", method="corner", budget="iterations = 2")
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2)) as tuner:
        tuner.run()
    asked = [t.gains["ctl.Kp"] for t in study.trials if t.source == "IS1"][2:]
    assert asked == pytest.approx([30.0 + 170.0 * 0.8, 30.0 + 170.0 * 0.7])


def test_the_program_lists_it_with_its_source(
    packages: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install(packages, "corner_listed", CORNER, "corner = corner_listed:Corner")
    assert main(["methods"]) == 0
    printed = capsys.readouterr().out
    assert "corner           walks from the upper corner" in printed
    assert "source: a test, 2026" in printed
    assert all(name in printed for name in METHODS)
    (default,) = [line for line in printed.splitlines() if line.endswith(" (default)")]
    assert default.split()[0] == DEFAULT_METHOD


def test_methods_of_gmfbo_come_first_and_cannot_be_replaced(packages: Path) -> None:
    renamed = CORNER.replace('"corner"', '"bo_ei"')
    install(packages, "corner_thief", renamed, "bo_ei = corner_thief:Corner")
    assert find_method("bo_ei") is METHODS["bo_ei"]
    assert all_methods()["bo_ei"] is METHODS["bo_ei"]


def test_an_unknown_name_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match="no method 'mfbo_takq'; did you mean 'mfbo_takg'"):
        find_method("mfbo_takq")


def test_a_study_of_a_removed_method_says_what_to_use_and_can_still_be_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = write_study(tmp_path, method="bo_ei", budget="iterations = 1")
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2)) as tuner:
        tuner.run()
    file, folder = tmp_path / "axis.toml", tmp_path / "axis.study"
    for path in (file, folder / "study.toml"):
        path.write_text(path.read_text().replace('"bo_ei"', '"rmfbo"'), encoding="utf-8")
    for command in (["tune", str(file), "--resume"], ["ask", str(file)]):
        assert main(command) == 2
        said = capsys.readouterr().err
        assert "method 'rmfbo': removed in 0.2.0; use one of gmfbo, gmfbo_paper," in said
    page, packed = tmp_path / "page.html", tmp_path / "packed.h5"
    for command in (
        ["report", str(folder), "--out", str(page)],
        ["export", str(folder), "--pack", str(packed)],
        ["repair", str(folder)],
    ):
        assert main(command) == 0, capsys.readouterr().err
    assert page.exists()
    assert packed.exists()


def test_a_package_that_cannot_be_loaded_is_named(packages: Path) -> None:
    install(packages, "corner_broken", "raise RuntimeError('no licence')", "mine = corner_broken:M")
    with pytest.raises(InputError, match=r"cannot load corner_broken:M .*no licence"):
        find_method("mine")


def test_what_is_no_method_is_refused_with_what_it_lacks(packages: Path) -> None:
    install(packages, "corner_empty", "class M:\n    name = 'mine'\n", "mine = corner_empty:M")
    with pytest.raises(InputError, match="expected corner_empty:M to have 'summary'"):
        find_method("mine")


def test_a_method_goes_by_one_name(packages: Path) -> None:
    install(packages, "corner_named", CORNER, "edge = corner_named:Corner")
    with pytest.raises(InputError, match="calls itself 'corner'"):
        find_method("edge")
