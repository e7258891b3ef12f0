"""A servo whose user knows fifteen parameters only roughly; its FMU is built for the draw."""

from __future__ import annotations

import os
import tempfile
from dataclasses import replace
from pathlib import Path

from fmu_build.compile import find_compiler
from fmu_build.declaration import read_declaration
from fmu_build.fmu import build_fmu
from fmu_build.platforms import this_platform
from tests.blind.machines import SERVO, Machine

FMU = "rich_axis.fmu"

_MEASURED = {
    "drag": ("drag", 2e-3),
    "pendulum": ("arm", 0.3),
    "pendulum_phase": ("arm_phase", 0.6),
    "spring": ("spring", 0.3),
    "spring_rest": ("spring_rest", 0.4),
    "cubic_spring": ("hardening", 0.03),
    "push": ("push", 0.12),
    "wave_1": ("ripple", 0.08),
    "wave_phase_1": ("ripple_phase", 1.0),
    "torque_gain": ("torque_gain", 1.0),
    "torque_lag": ("torque_lag", 5e-4),
    "filter_time": ("filter_time", 1e-3),
    "u_limit": ("torque_limit", 10.0),
}
"""Truth parameter = FMU parameter and what the user believes, in SI units, beside inertia and
viscous friction. The torque's gain cannot be told from all others together, and no recording
reaches the limit."""

RICH = replace(
    SERVO,
    name="rich",
    truth={
        **SERVO.truth,
        **{own: value for own, (_, value) in _MEASURED.items()},
        "wave_number_1": 12.0,
    },
    uncertain={**SERVO.uncertain, **{own: fmu for own, (fmu, _) in _MEASURED.items()}},
    fixed={"wave_number_1": "ripple_cycles"},
    fmus={"": FMU},
)


def rich_machine(models: Path) -> Machine:
    """The machine with its FMU in a folder, which is built if it is not there.

    Parameters
    ----------
    models : Path
        Folder for the FMU.
    """
    path = models.resolve() / FMU
    if not path.exists():
        models.mkdir(parents=True, exist_ok=True)
        declaration = read_declaration(Path(__file__).with_name("rich_axis") / "model.toml")
        target = this_platform()
        with tempfile.TemporaryDirectory() as work, tempfile.TemporaryDirectory() as cache:
            compiler = find_compiler("zig", Path(cache), [target])
            data = build_fmu(declaration, compiler, [target], Path(work))
        partial = path.with_suffix(f".{os.getpid()}")
        partial.write_bytes(data)
        partial.replace(path)
    return replace(RICH, fmus={"": str(path)})
