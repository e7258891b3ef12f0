"""A study whose file names no method goes on with the one that it was begun with."""

from __future__ import annotations

from gmfbo.tuning.study_file.study_file import FIRST_DEFAULT, as_begun, parse_study
from gmfbo.tuning.study_file.study_sections import DEFAULT_METHOD, StudyFile

TEXT = """
[is1]
twin = "axis.toml"
[is2]
twin = "twin.toml"
"""


def read(head: str = "") -> StudyFile:
    return parse_study(head + TEXT, label="study", default_name="study")


def test_a_new_study_takes_the_default() -> None:
    assert as_begun(read(), []).method == DEFAULT_METHOD


def test_a_begun_study_takes_the_method_that_was_logged() -> None:
    begun = [{"event": "begin", "method": "bo_ei"}, {"event": "begin"}]
    assert as_begun(read(), begun).method == "bo_ei"


def test_a_study_of_an_older_version_takes_the_default_of_its_time() -> None:
    assert as_begun(read(), [{"event": "begin"}]).method == FIRST_DEFAULT


def test_a_stated_method_counts() -> None:
    file = read('method = "random"\n')
    assert as_begun(file, [{"event": "begin", "method": "bo_ei"}]).method == "random"
