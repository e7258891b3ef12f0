"""Slow tests are skipped with a reason, and run when they are asked for."""

from __future__ import annotations

import pytest

from tests.conftest import pytest_collection_modifyitems


def skip_reason(item: pytest.Item) -> str | None:
    """Let the collection see a test, and return why it would be skipped."""
    pytest_collection_modifyitems([item])
    skip = item.get_closest_marker("skip")
    return None if skip is None else str(skip.kwargs["reason"])


@pytest.fixture
def slow_item(request: pytest.FixtureRequest) -> pytest.Item:
    item: pytest.Item = request.node
    item.add_marker(pytest.mark.slow)
    return item


def test_a_slow_test_is_skipped_with_a_reason(
    slow_item: pytest.Item, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("GMFBO_SLOW", raising=False)
    assert skip_reason(slow_item) == "slow: set GMFBO_SLOW=1 to run it"


def test_a_slow_test_runs_when_it_is_asked_for(
    slow_item: pytest.Item, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GMFBO_SLOW", "1")
    assert skip_reason(slow_item) is None


def test_control_a_test_without_the_mark_is_not_skipped(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("GMFBO_SLOW", raising=False)
    assert skip_reason(request.node) is None
