"""Safety of a study of the linear axis: its drive voltage reaches the limit at stiff gains."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin
from gmfbo.errors import RecordingError, StudyFileError
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.tuning.history.keep_out import KEEP_OUT_RADIUS, KeepOut
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.linear_study import linear_study
from tests.tuning.methods.quick_methods import QUICK

VOLTS = 6.0
SAFE = f"[safety]\ndrive_voltage = [-{VOLTS}, {VOLTS}]\nstart = [[60.0, 120.0], [80.0, 150.0]]\n"
PUBLISHED = "[objective]\nas_published = true\n"
"""Proposals are not simulated on draws of the twin beforehand, so that some runs are unsafe."""
EXPRESSION = '[safety]\nexpression = "abs(position - reference) < 0.5 and drive_voltage < 6.0"\n'


def run(study: Study) -> Study:
    with Tuner(study) as tuner:
        tuner.run()
    return study


def real(study: Study, status: str = "") -> list[Trajectory]:
    runs = [t.recording for t in study.trials if t.source == "IS1" and status in ("", t.status)]
    return [one for one in runs if isinstance(one, Trajectory)]


@pytest.mark.parametrize(
    "section", [f"[safety]\ndrive_voltage = [-{VOLTS}, {VOLTS}]\n", EXPRESSION]
)
def test_a_run_that_leaves_the_envelope_is_cut_priced_and_ends_nothing(
    tmp_path: Path, section: str
) -> None:
    sections = section + PUBLISHED
    study = run(linear_study(tmp_path, sections, method="random", iterations=4))
    cut = real(study, "unsafe")
    assert cut
    assert len(real(study)) == 2 + 4  # initial ones and queries
    assert study.objective is not None
    for trial in study.trials:
        if trial.status == "unsafe":
            assert trial.source == "IS1"
            assert trial.objective == pytest.approx(study.objective.failed)
            assert np.isfinite(trial.objective)
    for one in cut:
        voltage = np.abs(one.signal("drive_voltage"))
        assert voltage[-1] > VOLTS
        assert np.all(voltage[:-1] <= VOLTS)
        assert one.stopped_at == one.time[-1]
        assert one.message.startswith("left the safety envelope at 0.05")
    if study.best is not None:
        assert study.best.status == "ok"


def test_proposals_that_leave_the_envelope_on_draws_of_the_twin_are_withheld(
    tmp_path: Path,
) -> None:
    section = f"[safety]\ndrive_voltage = [-{VOLTS}, {VOLTS}]\n"
    study = run(linear_study(tmp_path, section, method="random", iterations=4))
    with Tuner(study) as tuner:
        events = tuner.history.store.events()
    withheld = {e["number"]: e["gains"] for e in events if e["event"] == "withheld"}
    assert withheld
    asked = {e["number"]: e["gains"] for e in events if e["event"] == "ask"}
    assert all(asked[number] != gains for number, gains in withheld.items())
    # As published the same seed makes unsafe runs: see the test above.
    assert real(study, "unsafe") == []


def test_negative_control_without_an_envelope_no_run_is_cut(tmp_path: Path) -> None:
    study = run(linear_study(tmp_path, method="random", iterations=4))
    assert real(study, "unsafe") == []
    assert max(np.abs(one.signal("drive_voltage")).max() for one in real(study)) > VOLTS


def test_a_study_starts_at_the_gains_known_to_be_safe(tmp_path: Path) -> None:
    study = run(linear_study(tmp_path, SAFE, iterations=0))
    first = [t for t in study.trials if t.source == "IS1"]
    assert [tuple(t.gains.values()) for t in first] == [
        pytest.approx((60.0, 120.0)),
        pytest.approx((80.0, 150.0)),
    ]
    assert {t.status for t in first} == {"ok"}


@pytest.mark.parametrize("method", ["random", "bo_ei", "gmfbo"])
def test_proposals_keep_away_from_where_a_run_was_unsafe(tmp_path: Path, method: str) -> None:
    study = linear_study(tmp_path, SAFE, method=method, iterations=4)
    with Tuner(study, method=QUICK[method]) as tuner:
        tuner.run()
        unit = tuner.history.unit_point
    unsafe: list[np.ndarray] = []
    safe: list[np.ndarray] = []
    for trial in study.trials:
        if trial.source != "IS1":
            continue
        point = unit(trial.gains)
        if unsafe:
            near = np.linalg.norm(np.array(unsafe) - point, axis=1).min() / np.sqrt(2)
            nearer = np.linalg.norm(np.array(safe) - point, axis=1).min() / np.sqrt(2)
            assert near > KEEP_OUT_RADIUS or nearer < near
        (unsafe if trial.status == "unsafe" else safe).append(point)


def test_negative_control_without_neighbourhoods_more_runs_are_unsafe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = run(
        linear_study(tmp_path / "kept", SAFE + PUBLISHED, method="random", seed=1, iterations=10)
    )

    def everywhere(_: KeepOut, points: np.ndarray, radius: float = 0.0) -> np.ndarray:
        return np.ones(len(points), dtype=bool)

    monkeypatch.setattr(KeepOut, "admits", everywhere)
    free = run(
        linear_study(tmp_path / "free", SAFE + PUBLISHED, method="random", seed=1, iterations=10)
    )
    assert len(real(kept, "unsafe")) < len(real(free, "unsafe"))


def test_a_twin_that_leaves_the_envelope_warns_before_the_axis_is_run(tmp_path: Path) -> None:
    study = run(linear_study(tmp_path, SAFE, method="random", seed=1, iterations=0))
    with Tuner(study) as tuner:
        keep_out = tuner.history.keep_out()
    assert len(keep_out.unsafe) > 0
    assert len(keep_out.safe) == 2
    twin = [t for t in study.trials if t.source == "IS2"]
    assert {t.status for t in twin} == {"ok"}


def test_a_run_without_a_watched_signal_counts_as_unsafe(tmp_path: Path) -> None:
    class Mute:
        name, content_hash = "mute", ""

        def __init__(self) -> None:
            self.axis = FmuTwin(models_folder() / "linear_axis.toml", isolated=False)

        def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
            whole = self.axis.run(gains, reference)
            return Trajectory(time=whole.time, signals={"position": whole.signal("position")})

        def close(self) -> None:
            self.axis.close()

    study, plant = linear_study(tmp_path, SAFE, iterations=0), Mute()
    with Tuner(study, is1=plant) as tuner:
        tuner.run()
    plant.close()
    assert [one.status for one in real(study)] == ["unsafe", "unsafe"]
    assert "speaks of 'drive_voltage', which the run does not hold" in real(study)[0].message


def test_a_told_recording_is_judged_too(tmp_path: Path) -> None:
    study = linear_study(tmp_path, SAFE, iterations=0)
    with Tuner(study) as tuner:
        request = tuner.ask()
        assert request is not None
        reference = tuner.experiment.reference
        silent = {"position": np.zeros(len(reference))}
        with pytest.raises(RecordingError, match="speaks of 'drive_voltage'"):
            tuner.tell(request, Recording(time=reference.time, signals=silent))
        loud = {**silent, "drive_voltage": np.full(len(reference), 9.0)}
        told = tuner.tell(request, Recording(time=reference.time, signals=loud))
    assert told.status == "unsafe"
    assert len(told.recording) == len(reference)


def test_an_envelope_of_unknown_signals_and_starts_outside_are_refused(tmp_path: Path) -> None:
    with pytest.raises(StudyFileError, match=r"no signal 'voltage'; did you mean 'drive_voltage'"):
        Tuner(linear_study(tmp_path / "a", "[safety]\nvoltage = [-1.0, 1.0]\n"))
    with pytest.raises(StudyFileError, match=r"one value for each of kp, kv, got \[60\.0\]"):
        Tuner(linear_study(tmp_path / "b", "[safety]\nstart = [[60.0]]\n"))
    with pytest.raises(StudyFileError, match=r"'kp' within \[40, 320\], got 900; widen"):
        Tuner(linear_study(tmp_path / "c", "[safety]\nstart = [[900.0, 100.0]]\n"))
    with pytest.raises(StudyFileError, match=r"\[safety\]: x: expected \[low, high\], got 3"):
        linear_study(tmp_path / "d", "[safety]\nx = 3\n")
    with pytest.raises(StudyFileError, match=r"\[safety\]: expression 'open\(1\) < 2'"):
        linear_study(tmp_path / "e", '[safety]\nexpression = "open(1) < 2"\n')


@pytest.mark.parametrize(
    ("kp", "now", "message"),
    [
        (
            "values = [50, 100, 150]",
            80,
            r"\[gains\] now: expected 'kp' to be one of 50, 100, 150, got 80",
        ),
        ("low = 40, high = 320, integer = true", 80.5, r"'kp' to be one of 40, 41, .*, got 80\.5"),
    ],
)
def test_gains_in_force_that_a_gain_may_not_take_are_refused(
    tmp_path: Path, kp: str, now: float, message: str
) -> None:
    gains = f"[gains]\nkp = {{ {kp}, now = {now} }}\nkv = {{ low = 90, high = 200, now = 120 }}\n"
    with pytest.raises(StudyFileError, match=message) as refused:
        Tuner(linear_study(tmp_path / "now", gains))
    assert "\n" not in str(refused.value)
    start = f"[gains]\nkp = {{ {kp} }}\n[safety]\nstart = [[{now}, 120.0]]\n"
    with pytest.raises(StudyFileError, match=r"\[safety\] start: expected 'kp' to be one of"):
        Tuner(linear_study(tmp_path / "start", start))
    allowed = gains.replace(f"now = {now}", "now = 100")
    with Tuner(linear_study(tmp_path / "allowed", allowed, iterations=0)) as tuner:  # control
        request = tuner.ask()
    assert request is not None
    assert request.gains["kp"] == 100.0
