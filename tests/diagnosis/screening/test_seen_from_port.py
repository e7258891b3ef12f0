"""Residuals read backwards to the port: transposes of whitening and of the response."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from gmfbo.diagnosis.screening.seen_from_port import fields, unwhitened, whitened_columns
from tests.diagnosis.port_cases import PortCase, open_servo, port_case


@pytest.fixture(scope="module")
def servo() -> Iterator[PortCase]:
    case = open_servo({})
    yield port_case(case)
    case.simulations.close()


def test_unwhitened_is_the_transpose_of_whitening_with_its_nuisances(servo: PortCase) -> None:
    rng = np.random.default_rng(0)
    for whitener in servo.case.misfit.whiteners:
        assert whitener.nuisances is not None
        record = servo.case.simulations.records[whitener.window.record]
        columns = [rng.standard_normal(signal.values.size) for signal in record.signals]
        block = rng.standard_normal(whitener.n_residuals)
        there = float(whitener.whiten(columns) @ block)
        parts = zip(unwhitened(whitener, block), columns, whitener.window.rows, strict=True)
        back = sum(float(part @ column[rows]) for part, column, rows in parts)
        assert back == pytest.approx(there, rel=1e-9)


def test_the_field_of_a_residual_gives_every_torques_share_in_it(servo: PortCase) -> None:
    rng = np.random.default_rng(1)
    torques = [rng.standard_normal(rows) for rows in servo.response.rows]
    columns = whitened_columns(servo.case.misfit, servo.response, [t[None] for t in torques])
    residual = tuple(np.array(rng.standard_normal(block.shape[1])) for block in columns)
    there = sum(float(c[0] @ r) for c, r in zip(columns, residual, strict=True))
    seen = fields(servo.case.misfit, servo.response, residual)
    assert sum(float(s @ t) for s, t in zip(seen, torques, strict=True)) == pytest.approx(there)
