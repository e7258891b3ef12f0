"""The line of a twin file on which an entry stands."""

from __future__ import annotations

import pytest

from gmfbo import FmuTwin, models_folder
from gmfbo.sources.twin_file.toml_lines import line_of

TEXT = """name = "axis"
[gains]
"mech.J" = [1, 2]
[uncertain]  # known roughly
# "mech.J" = [0, 1]
"mech.J" = [0.06, 0.24]
viscous=[0.0, 1.0]
"""


@pytest.mark.parametrize(("key", "line"), [("mech.J", 6), ("viscous", 7), ("J", None)])
def test_the_line_is_that_of_the_entry_in_its_own_table(key: str, line: int | None) -> None:
    assert line_of(TEXT, "uncertain", key) == line


def test_the_place_of_an_entry_is_file_and_line() -> None:
    path = models_folder() / "servo_axis.toml"
    with FmuTwin(path) as twin:
        told = twin.place_of("uncertain", "viscous")
        assert twin.place_of("uncertain", "nothing") == "servo_axis.toml"
    name, number = told.split(", line ")
    assert name == "servo_axis.toml"
    assert path.read_text(encoding="utf-8").splitlines()[int(number) - 1].startswith('"viscous"')
