"""A run whose loop is unstable is no run, though it reached its end."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.sources.fmu_file.job import Outcome
from gmfbo.sources.twin.response import Response


@pytest.mark.parametrize(("largest", "is_finite"), [(1.0, True), (1e99, True), (1e199, False)])
def test_a_signal_whose_square_overflows_is_not_finite(largest: float, is_finite: bool) -> None:
    response = Response(Outcome("ok", 3), {}, {}, {}, {}, {}, np.zeros(3))
    assert Simulated((np.array([0.0, -largest, 1.0]),), response).finite is is_finite
