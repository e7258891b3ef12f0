"""A command is a number in a controller: it has no zero error unless the twin file says so."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from gmfbo import FmuTwin
from gmfbo.diagnosis.comparison.opened_comparison import problem_on
from tests.diagnosis.servo_recordings import rewritten
from tests.diagnosis.short_recordings import SERVO, open_small

COMMAND, WITH_ZERO = (
    'torque_command = "torque_command"',
    'torque_command = { variable = "torque_command", offset = "fit" }',
)


def free_zeros(twin: FmuTwin) -> set[str]:
    with closing((case := open_small(twin, SERVO.recordings({}))).simulations):
        names = problem_on(case, case.budget.windows).logging.names
    return {signal for kind, signal in names if kind == "offset"}


def test_a_command_has_no_free_zero() -> None:
    assert free_zeros(SERVO.twin()) == set()


def test_one_that_is_stated_is_free(tmp_path: Path) -> None:
    twin = rewritten("servo_axis", tmp_path, {COMMAND: WITH_ZERO})
    assert free_zeros(twin) == {"torque_command"}


def test_a_torque_that_is_measured_may_have_one(tmp_path: Path) -> None:
    twin = rewritten("servo_axis", tmp_path, {'\ncommand = "torque_command"': ""})
    assert free_zeros(twin) == {"torque_command"}
