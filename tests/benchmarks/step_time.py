"""Time of one step at 60 data points on one thread, simulation excluded.

With the surrogate over gains and source (`gmfbo_paper`), a twin step fits it and maximises the
acquisition; a real step refits the correction and makes four corrected predictions before that.
`gmfbo` asks the real axis only: its step is a real one, and its 60 data points are the runs
beyond its survey of the twin. Limits: 0.5 s and 1.0 s. The data come from studies of the drive.

    python tests/benchmarks/step_time.py
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np

from gmfbo import FmuTwin, Study, Tuner
from gmfbo.acquisition.improvement import CostAwareExpectedImprovement
from gmfbo.acquisition.maximise import maximise
from gmfbo.correction.trajectory_gp import Pair, TrajectoryCorrection
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.surrogate.observations import Observations
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods import find_method
from gmfbo.tuning.methods.beliefs import search_of
from gmfbo.tuning.methods.gmfbo_paper import fit_surrogate, printed_mismatch

RESULT = Path(__file__).parent / "results" / "step_time" / "step_time.txt"
POINTS = 60
REPEATS = 5
TWIN_LIMIT_S, REAL_LIMIT_S = 0.5, 1.0

STUDY = """
seed = 0
method = "{method}"
[is1]
twin = {twin}
[is2]
twin = {twin}
parameters = {{ "map.noise" = 0.5, "map.seed" = "seed" }}
[budget]
iterations = 100
"""

Made = TypeVar("Made")


def study_of(folder: Path, method: str) -> tuple[TuningState, Pair]:
    """Run a study until it holds 60 observations; the last run of axis and twin."""
    twin = models_folder() / "drive_twin.toml"
    file = folder / f"{method}.toml"
    text = STUDY.format(method=method, twin=json.dumps(twin.as_posix()))
    file.write_text(text, encoding="utf-8")
    with Tuner(Study.read(file)) as tuner, FmuTwin(twin) as axis:
        enough = POINTS + tuner.history.survey
        while len(tuner.history.observations()) < enough:
            request = tuner.ask()
            if request is None:
                raise SystemExit(f"the budget ended before {POINTS} observations")
            tuner.tell(request, axis.run(request.gains, tuner.experiment.reference))
        history, signal = tuner.history, tuner.experiment.signal
        beside = [trial for trial in history.of("IS2") if trial.parent is not None][-1]
        real = next(trial for trial in history.of("IS1") if trial.number == beside.parent)
        pair = Pair(
            beside.recording.time, beside.recording.signal(signal), real.recording.signal(signal)
        )
        return history.state({}), pair


def timed(action: Callable[[], Made]) -> tuple[Made, float]:
    """Result, and the least time [s] of some repeats: neighbours on the machine only add."""
    seconds = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        made = action()
        seconds.append(time.perf_counter() - began)
    return made, min(seconds)


def main() -> int:
    """Measure, print where the time goes, and keep it."""
    with tempfile.TemporaryDirectory() as folder:
        state, pair = study_of(Path(folder), "gmfbo_paper")
        surveyed, _ = study_of(Path(folder), "gmfbo")
    sixty = state.observations[:POINTS]
    data = Observations.gather([(seen.point, seen.source, seen.objective) for seen in sixty])
    model, fit_s = timed(lambda: fit_surrogate(data, printed_mismatch(state)))
    best = {name: float(data.values[data.of(name)].min()) for name in ("IS1", "IS2")}
    acquisition = CostAwareExpectedImprovement(model, best, {"IS1": 1.0, "IS2": 0.3})
    _, search_s = timed(lambda: maximise(acquisition, search_of(state), ["IS1", "IS2"], data))
    correction, correction_s = timed(lambda: TrajectoryCorrection.fit([pair]))
    _, corrected_s = timed(
        lambda: [correction.correct(pair.time, pair.simulated) for _ in range(4)]
    )
    method = find_method("gmfbo")
    _, proposal_s = timed(lambda: method.propose(surveyed, np.random.default_rng(0)))
    twin_s = fit_s + search_s
    real_s = twin_s + correction_s + corrected_s
    default_s = proposal_s + correction_s + corrected_s
    rows = [
        (f"surrogate fit, {len(data)} points", fit_s),
        ("acquisition, two sources", search_s),
        (f"twin step (limit {TWIN_LIMIT_S} s)", twin_s),
        (f"correction fit, {len(pair.time)} samples thinned", correction_s),
        ("four corrected trajectories", corrected_s),
        (f"real step (limit {REAL_LIMIT_S} s)", real_s),
        (f"gmfbo: proposal, {len(surveyed.observations)} runs", proposal_s),
        (f"gmfbo: real step (limit {REAL_LIMIT_S} s)", default_s),
    ]
    text = "\n".join(f"{label:<42}{seconds:8.3f} s" for label, seconds in rows)
    text += "\n"
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(f"$ python tests/benchmarks/step_time.py\n{text}", encoding="utf-8")
    print(text)
    return 0 if twin_s <= TWIN_LIMIT_S and max(real_s, default_s) <= REAL_LIMIT_S else 1


if __name__ == "__main__":
    sys.exit(main())
