"""What a further run is worth, and the noise of one run, on axes whose noise is known."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from gmfbo import FmuTwin
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.tuning.history.worth import expected_gain, noise_of_one_run
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner

TWIN = json.dumps((models_folder() / "linear_axis.toml").as_posix())
STUDY = """
name = "noisy"
seed = {seed}
method = "bo_ei"
[is1]
twin = {twin}
{noise}
[is2]
twin = {twin}
parameters = {{ mass = 150.0 }}
[gains]
kp = [100.0, 110.0]
kv = [200.0, 210.0]
[reference]
step = 2e-4
at = 0.05
horizon = 0.4
[budget]
is1_runs = {runs}
"""
QUANTILES = norm.ppf((np.arange(20_000) + 0.5) / 20_000)
"""Of the normal distribution, in place of draws from it."""

DEVIATION = 4e-6
"""[m] A fiftieth of the step."""

NOISE = f"noise = {{ position = {DEVIATION} }}"


def written(folder: Path, noise: str, *, runs: int = 6, seed: int = 0) -> Study:
    folder.mkdir(parents=True, exist_ok=True)
    text = STUDY.format(twin=TWIN, noise=noise, runs=runs, seed=seed)
    (folder / "noisy.toml").write_text(text, encoding="utf-8")
    return Study.read(folder / "noisy.toml")


def worth(study: Study) -> list[dict[str, float]]:
    with StudyStore.open(study.location) as store:
        return [event for event in store.events() if event["event"] == "worth"]


@given(st.floats(-3.0, 3.0), st.floats(0.01, 3.0), st.floats(-3.0, 3.0))
def test_the_expected_gain_is_the_mean_of_what_draws_gain(
    mean: float, std: float, incumbent: float
) -> None:
    draws = mean + std * QUANTILES
    gained = float(np.mean(np.maximum(incumbent - draws, 0.0)))
    assert expected_gain((mean, std), incumbent) == pytest.approx(gained, abs=2e-3 * std)


def test_the_noise_of_one_run_is_what_repetitions_of_it_show(tmp_path: Path) -> None:
    study = written(tmp_path, NOISE, runs=3)
    with Tuner(study) as tuner:
        tuner.run()
        state = tuner.history.state({})
        known = noise_of_one_run(state)
        trial = tuner.history.of("IS1")[-1]
        experiment = tuner.experiment
    with FmuTwin(models_folder() / "linear_axis.toml", isolated=False) as axis:
        run = axis.run(trial.gains, experiment.reference)
    draws = np.random.default_rng(1).standard_normal((200, run.time.size))
    metrics = experiment.metrics_of(run.time, run.signal("position") + DEVIATION * draws)
    repeated = float(np.std(state.objective.value(metrics)))
    # The level of the noise itself is known from a tenth of a second of one run.
    assert known == pytest.approx(repeated, rel=0.5)


def test_where_a_run_promises_less_than_its_noise_the_last_two_repeat_the_recommended_gains(
    tmp_path: Path,
) -> None:
    study = written(tmp_path, NOISE)
    with Tuner(study) as tuner:
        result = tuner.run()
        real = [tuple(trial.gains.values()) for trial in tuner.history.of("IS1")]
    told = worth(study)
    assert [event["confirms"] for event in told][-2:] == [True, True]
    assert all(event["gain"] < event["noise"] for event in told)
    assert len(real) == 6  # they are counted
    assert all(gains in real[:-2] for gains in real[-2:])
    assert result.recommendation is not None
    assert tuple(result.recommendation.gains.values()) in real
    assert any("less than the noise of one run" in remark for remark in result.remarks)


def test_control_without_noise_no_run_is_repeated(tmp_path: Path) -> None:
    study = written(tmp_path, "")
    with Tuner(study) as tuner:
        result = tuner.run()
        real = [tuple(trial.gains.values()) for trial in tuner.history.of("IS1")]
    assert worth(study) == []
    assert len(set(real)) == len(real)
    assert not any("noise of one run" in remark for remark in result.remarks)


def test_a_study_begun_before_repeats_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gmfbo.tuning.study.study.OBJECTIVE_VERSION", 2)
    study = written(tmp_path, NOISE)
    with Tuner(study) as tuner:
        tuner.run()
        real = [tuple(trial.gains.values()) for trial in tuner.history.of("IS1")]
    assert worth(study) == []
    assert len(set(real)) == len(real)
