"""A share of the campaign of `tests/benchmarks/fuzz_readers.py`: only our own errors come out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from gmfbo.recordings.reading_process import reading_process
from tests.fuzz.targets import TARGETS
from tests.fuzz.trying import Tally, try_file

_PACKAGES = {"Parquet": "pyarrow", "MDF": "asammdf", "TDMS": "nptdms"}
_EXAMPLES = 30


@pytest.mark.parametrize("name", TARGETS)
def test_only_our_own_errors_come_out_of_a_hostile_file(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name in _PACKAGES:
        package = _PACKAGES[name]
        pytest.importorskip(package, reason=f"needs {package}: pip install 'gmfbo[{name.lower()}]'")
    target, tally = TARGETS[name], Tally()
    monkeypatch.setattr(reading_process, "TIME_LIMIT_S", 5.0)

    @settings(
        max_examples=_EXAMPLES,
        deadline=None,
        derandomize=True,
        database=None,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )
    @given(data=st.data())
    def tried(data: st.DataObject) -> None:
        assert try_file(target, data.draw(target.files()), tmp_path, tally) == []

    tried()
    assert tally.tried >= _EXAMPLES
    # A damaged event line is passed over and told, never refused.
    assert tally.refused or name == "events", "nothing was refused: the files are not hostile"
    assert tally.read, "nothing was read: the files do not reach what lies deep"


def test_the_campaign_sees_a_foreign_error(tmp_path: Path) -> None:
    """Negative control: a reader that lets a foreign error out is a fault."""

    def careless(path: Path) -> None:
        raise KeyError(path.name)

    tally = Tally()
    target = replace(TARGETS["CSV"], read=careless)
    assert try_file(target, b"x", tmp_path, tally) == ["KeyError: 'a.csv'"]
    assert tally.faults == ["KeyError: 'a.csv'"]
