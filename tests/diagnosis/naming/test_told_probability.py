"""A probability grows with belief and evidence, and is worth what the draw says."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.naming.worth import worth

BELIEFS, GAINS = st.floats(0.0, 1.0), st.floats(-10.0, 1e7)


@given(BELIEFS, BELIEFS, GAINS, GAINS)
def test_who_believes_more_on_more_evidence_is_never_less_sure(
    one: float, other: float, gain: float, more: float
) -> None:
    (low, high), (little, much) = sorted((one, other)), sorted((gain, more))
    assert 0.0 < worth(low, little) <= worth(high, much) < 1.0


def test_weak_evidence_is_no_fact_however_sure_the_comparison_is() -> None:
    assert worth(1.0, 10.0) < 0.8 < worth(1.0, 100.0)
