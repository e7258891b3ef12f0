"""[fixed] names parameters that are known for certain, by name or shell pattern."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo.errors import TwinFileError
from gmfbo.sources.binding.content_hash import content_hash
from gmfbo.sources.binding.name_patterns import matching
from tests.diagnosis.servo_recordings import rewritten


def with_fixed(folder: Path, names: str) -> Path:
    table = f"[fixed]\nnames = {names}\n\n[roles]"
    return rewritten("servo_axis", folder, {"[roles]": table}).path


@pytest.mark.parametrize("names", ['["torque_limit"]', '["torque_*", "filter_time"]', "[]"])
def test_names_and_patterns_are_taken(tmp_path: Path, names: str) -> None:
    assert with_fixed(tmp_path, names).exists()


@pytest.mark.parametrize(
    ("names", "said"),
    [
        ('["torque_limt"]', r"no parameter matches 'torque_limt'; did you mean 'torque_limit'\?$"),
        ('["nothing.*"]', r"\[fixed\] names: no parameter matches 'nothing\.\*'"),
        ('["inertia"]', r"'inertia' holds 'inertia' of \[uncertain\]; keep one$"),
        ('["inert*"]', r"'inert\*' holds 'inertia' of \[uncertain\]"),
        ('["position"]', "no parameter matches 'position'"),
        ('"torque_limit"', "fixed"),
    ],
)
def test_what_matches_nothing_or_contradicts_is_refused_in_one_line(
    tmp_path: Path, names: str, said: str
) -> None:
    with pytest.raises(TwinFileError, match=said) as refused:
        with_fixed(tmp_path, names)
    assert "\n" not in str(refused.value)


def test_what_is_certain_changes_no_run(tmp_path: Path) -> None:
    """A study goes on where the list was changed: its runs are the same."""
    plain = rewritten("servo_axis", tmp_path, {})
    before = content_hash(plain.binding, {}, plain.step)
    table = '[fixed]\nnames = ["torque_limit"]\n\n[roles]'
    after = rewritten("servo_axis", tmp_path, {"[roles]": table})
    assert content_hash(after.binding, {}, after.step) == before


def test_a_name_with_brackets_stands_for_itself() -> None:
    names = ["map[1]", "map1", "map[2]"]
    assert matching("map[1]", names) == ["map[1]"]
    assert matching("map[[]*", names) == ["map[1]", "map[2]"]
    assert matching("Map*", names) == []
