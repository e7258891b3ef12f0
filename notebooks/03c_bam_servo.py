# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # What a hobby servo's twin lacks: friction that grows with the load
#
# A Dynamixel XL330 swings 0.49 kg on an arm of 0.1 m (Duclusaud et al., ICRA 2025, arXiv
# 2410.08650; repository Rhoban/bam, branch `xl330`, Apache-2.0). Four motions were recorded at each
# of four firmware gains. The twin knows the proportional law, the PWM with its limit, the motor
# with its back-EMF, armature and gravity; its friction is viscous only. It is diagnosed on the
# gains 100 and 400 and judged on 200 and 800, which no fit sees.
#
# Put the JSON files into `bam_xl330/raw` and set `GMFBO_DATA` to the folder that holds `bam_xl330`.

# %%
import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from gmfbo import AugmentedTwin, FmuTwin, Recording, diagnose, models_folder, write_recording
from gmfbo.objective.fit import compare_at

twin = FmuTwin(models_folder() / "servo_pendulum.toml")
raw = Path(os.environ["GMFBO_DATA"]) / "bam_xl330" / "raw"

# %% [markdown]
# ## From JSON to CSV
#
# The loggers' rows are 4 to 5.3 ms apart, by turns: they are laid on 5 ms. The gain goes into the
# head of the file as `# servo.kp = 400`; `load` is the PWM in 1/885 as a 16-bit number. After 2 s
# of `lift_and_drop` the bridge is opened. That part is cut off: a servo whose loop opens on the
# way is not one in closed loop.

# %%
SAMPLE = 5e-3  # [s]
FULL_DUTY = 885.0


def read_log(path: Path) -> Recording:
    """Read one log of the rig as far as its motor is on, on an even grid."""
    log = json.loads(path.read_text())
    columns = {
        key: np.array([float(row[key]) for row in log["entries"]]) for key in log["entries"][0]
    }
    on = columns["torque_enable"] > 0.5
    last = int(np.argmin(on)) if not on.all() else on.size
    time = columns["timestamp"][:last]
    grid = np.arange(np.ceil(time[0] / SAMPLE), np.floor(time[-1] / SAMPLE) + 1.0) * SAMPLE
    pwm = np.where(columns["load"] > 32767, columns["load"] - 65536, columns["load"])
    logged = {
        "reference": columns["goal_position"],
        "position": columns["position"],
        "duty": pwm / FULL_DUTY,
    }
    return Recording(
        time=grid,
        signals={key: np.interp(grid, time, column[:last]) for key, column in logged.items()},
        units={"reference": "rad", "position": "rad"},
        parameters={"servo.kp": float(log["kp"])},
        name=f"{log['trajectory']}_{log['kp']}.csv",
    )


runs: dict[float, list[Recording]] = {}
with tempfile.TemporaryDirectory() as folder:
    for file in sorted(raw.glob("*.json")):
        log = read_log(file)
        path = write_recording(log, Path(folder) / log.name)
        runs.setdefault(log.parameters["servo.kp"], []).append(Recording.read(path, twin))
print(path.name, *(f"kp {kp:.0f}: {len(of_gain)} runs" for kp, of_gain in runs.items()))

# %% [markdown]
# ## Ask
#
# Resistance, armature, viscous friction and the encoder's zero are refitted in the search: what
# they explain by themselves is not missing physics. Friction may depend on the load torque, here
# that of the motor, which is what the gear takes in (twin file, `[states] load_torque`).

# %%
seen = [*runs[100.0], *runs[400.0]]
unseen = [*runs[200.0], *runs[800.0]]
diagnosis = diagnose(twin, seen, unseen, seed=0)
print(repr(diagnosis))
for effect in diagnosis.effects:
    rivals = ", ".join(effect.indistinguishable_from) or "nothing"
    print(f"{effect.name}: probability {effect.probability:.2f}, cannot be told from {rivals}")

# %% [markdown]
# ## Against every other friction
#
# Is the name more than a better fit? Each friction law gets the same chance: its own sizes and the
# twin's uncertain parameters are fitted to the positions of the gains 100 and 400, whole runs in
# closed loop, and the law then has to foretell those of 200 and 800. The diagnosis itself fits
# position and duty together, and is judged by its exported FMU.

# %%
UNCERTAIN = {"motor.resistance": 3.4, "motor.armature": 1.8e-3, "viscous": 5e-3, "load.tilt": 0.03}
BRISTLE = 1e-3  # [rad] below the encoder's step: the law is sliding friction
LAWS: Mapping[str, dict[str, float]] = {
    "viscous": {},
    "coulomb_friction": {"level": 0.01},
    "stribeck_friction": {"level": 0.01, "breakaway": 0.02, "velocity": 1.0},
    "load_dependent_friction": {"level": 0.01, "coefficient": 0.2},
}


class Rollouts:
    """Positions of the twin with one friction law along the runs, as residuals [rad]."""

    def __init__(self, axis: AugmentedTwin, law: str) -> None:
        self.axis, self.law, self.names = axis, law, [*UNCERTAIN, *LAWS[law]]
        self.start = np.array([*UNCERTAIN.values(), *LAWS[law].values()])

    def residuals(self, values: NDArray[np.float64], logs: list[Recording]) -> NDArray[np.float64]:
        """Recorded less simulated position of all rows of all runs."""
        given = dict(zip(self.names, values.tolist(), strict=True))
        parameters = {name: given[name] for name in UNCERTAIN}
        physics = {f"{self.law}.{name}": given[name] for name in LAWS[self.law]}
        if physics:
            physics[f"{self.law}.deflection"] = BRISTLE
        errors = []
        for log in logs:
            plan = self.axis.plan(log, {})
            held = self.axis.run(plan, parameters, physics).held["position"]
            errors.append(log.signal("position") - np.interp(log.time, plan.grid, held))
        return np.concatenate(errors)

    def fitted(self, logs: list[Recording]) -> NDArray[np.float64]:
        """Values of least squares; a law's size is 0 or more."""
        floor = [-np.inf if name == "load.tilt" else 1e-6 for name in self.names]
        scale = np.maximum(np.abs(self.start), 1e-3)
        found = least_squares(
            lambda x: self.residuals(x * scale, logs),
            self.start / scale,
            bounds=(floor / scale, np.inf),
            diff_step=1e-3,
            ftol=1e-4,
            xtol=1e-3,
            max_nfev=12,
        )
        return np.asarray(found.x * scale)


def mean_error(model: FmuTwin, logs: list[Recording]) -> float:
    """Mean absolute error of the position [rad], over all rows of all runs."""
    errors = [compare_at(model.run({}, log), log, "position") for log in logs]
    return float(np.mean(np.abs(np.concatenate(errors))))


table: dict[str, tuple[float, float]] = {}
with AugmentedTwin(twin, substeps=2, isolated=False) as axis:
    for law in LAWS:
        rollouts = Rollouts(axis, law)
        best = rollouts.fitted(seen)
        seen_error, unseen_error = (
            float(np.mean(np.abs(rollouts.residuals(best, logs)))) for logs in (seen, unseen)
        )
        table[law] = (seen_error, unseen_error)
with diagnosis.augmented_twin() as augmented:
    table["the diagnosis"] = (mean_error(augmented, seen), mean_error(augmented, unseen))
print("mean error of the position [rad]   kp 100, 400   kp 200, 800 (unseen)")
for law, (on_seen, on_unseen) in table.items():
    print(f"{law:<34} {on_seen:11.4f} {on_unseen:13.4f}")

# %% [markdown]
# ## What this says, and what it does not
#
# Coulomb and Stribeck friction gain three per cent or four on unseen gains, friction in proportion
# to the motor's torque a quarter. The authors found the same on 240 runs: their `m5` has 0.29 times
# the motor's torque and next to no constant friction. So has the diagnosis: about half the load,
# and less than 20 mN m without load (their `m4` has 9). Beside it a cogging "may be" missing, and a
# torque that passed once, in one run, which shows in one stretch only: no more than that. With
# them and parameters that differ from one recording to the next, held-out runs are met better by a
# quarter in the position and an eighth in the duty. Which values in these intervals a fit ends at
# changes with the engine: 0.42 to 0.54 times the load so far, and so does what stands beside it.
# Whether Coulomb friction alone could do it hangs by less: engines before this one told the one
# law, or a set of both, by how a sum was rounded.
#
# It is far from all: of what is more than noise, most is explained by no law. An encoder of
# 4096 steps has little noise, and the twin is still a twentieth of the stroke off. The authors add
# that load and drive rub differently, a law the library does not have. The supply is taken as a
# constant 7.4 V though it sags by 0.3 V, and the motor warmed from 27 to 39 degC from the first
# gain to the last. Where the firmware's duty saturates, duty and position no longer err together:
# what the twin lacks may reach each of them by itself.

# %%
named = {effect.name: effect for effect in diagnosis.effects}
assert diagnosis.verdict == "outside_library", "the laws explain less than half"
assert diagnosis.effects[0].name == "load_dependent_friction"
assert not {"coulomb_friction", "stribeck_friction"} & set(named)
friction = named["load_dependent_friction"]
assert friction.probability > 0.5, "of its set it is the likeliest"
assert diagnosis.remainder is not None
assert diagnosis.remainder.share > 0.5
assert abs(friction.parameters["coefficient"].value - 0.5) < 0.1
assert friction.parameters["level"].high < 20e-3, "[N m]"

simpler = min(table[law][1] for law in ("viscous", "coulomb_friction", "stribeck_friction"))
assert 0.07 < simpler < 0.08, "as others have measured it"
assert table["load_dependent_friction"][1] < 0.85 * simpler
assert table["the diagnosis"][1] < 0.92 * simpler
