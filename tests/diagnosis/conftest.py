"""Cases that many tests look at and none changes: opened once a process."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from gmfbo.diagnosis.case.case import Case
from tests.diagnosis.port_cases import PortCase, open_servo, port_case
from tests.diagnosis.servo_recordings import opened


@pytest.fixture(scope="session")
def right_servo() -> Iterator[PortCase]:
    """Servo axis that lacks nothing, with the response of its torque port."""
    case = open_servo({})
    yield port_case(case)
    case.simulations.close()


@pytest.fixture(scope="session")
def right_case() -> Iterator[Case]:
    """Servo axis that lacks nothing, with noise that its controller reads."""
    case = opened({})
    yield case
    case.simulations.close()
