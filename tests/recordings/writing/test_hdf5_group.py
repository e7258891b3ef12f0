"""Digest of what an HDF5 group is to hold, and of what it holds."""

from __future__ import annotations

import io

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gmfbo.errors import RecordingError
from gmfbo.recordings.writing.hdf5_group import (
    GroupContent,
    content_digest,
    content_of,
    file_image,
    texts,
    write_content,
)

TEXTS = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=5)
NUMBERS = st.floats(width=64) | st.integers(-(2**60), 2**60) | st.booleans()
ATTRIBUTES = NUMBERS | TEXTS | st.lists(TEXTS, max_size=3).map(texts)
# Short names of few letters: groups in groups, and names whose order is not that of their text.
PATHS = st.lists(st.text("ab-0éΩ", min_size=1, max_size=2), min_size=1, max_size=3).map("/".join)


@st.composite
def contents(draw: st.DrawFn) -> GroupContent:
    content = GroupContent(draw(st.dictionaries(TEXTS.filter(bool), ATTRIBUTES, max_size=4)))
    for path in draw(st.lists(PATHS, max_size=5, unique=True)):
        taken = content.datasets
        if not any(
            f"{one}/".startswith(f"{path}/") or f"{path}/".startswith(f"{one}/") for one in taken
        ):
            values = np.array(draw(st.lists(st.floats(), max_size=3)), dtype=np.float64)
            content.add_column(path, values, "signal", draw(st.none() | TEXTS))
    return content


@settings(deadline=None)
@given(contents())
def test_what_was_written_has_the_digest_of_what_was_to_be_written(content: GroupContent) -> None:
    image = file_image(lambda root: write_content(root, content))
    with h5py.File(io.BytesIO(image)) as file:
        assert content_digest(content_of(file)) == content_digest(content)


def test_a_value_a_name_and_an_attribute_each_change_the_digest() -> None:
    def digest(name: str, values: list[float], unit: str) -> str:
        content = GroupContent()
        content.add_column(name, np.array(values), "signal", unit)
        return content_digest(content)

    digests = {digest("a", [1.0], "m"), digest("b", [1.0], "m"), digest("a", [2.0], "m")}
    assert len(digests | {digest("a", [1.0], "s")}) == 4


def test_two_columns_of_one_name_are_refused() -> None:
    content = GroupContent()
    content.add_column("a", np.zeros(2), "signal", None)
    with pytest.raises(RecordingError, match="'a': cannot be stored in HDF5, there are two"):
        content.add_column("a", np.ones(2), "schedule", None)


def test_the_digest_of_studies_that_were_stored_stays() -> None:
    """The number is of the code before contents were made (c07b5a3b), read back from HDF5."""
    content = GroupContent(
        {
            "number": 7,
            "accepted": True,
            "objective": -0.25,
            "status": "ok",
            "use": np.array((0.1, 0.2)),
            "std": texts([]),
            "signals": texts(["é", "b/c"]),
        }
    )
    content.add_values("metric", {"rise_time": np.nan})
    content.add_column("b/c", np.array([1.0, -0.0]), "signal", "rad")
    content.add_column("é", np.array([2.0]), "signal", None)
    assert content_digest(content) == "58c251768f9b3da7875b5be1fcba54d5"


@pytest.mark.parametrize("name", ["a\0b", "a\udc80"])
def test_a_name_that_hdf5_would_not_give_back_is_refused(name: str) -> None:
    content = GroupContent()
    content.add_values("parameter", {name: 1.0})
    with pytest.raises(RecordingError, match=r"'parameter\.a.*cannot be stored in HDF5"):
        file_image(lambda root: write_content(root, content))


def test_a_value_is_a_number_or_an_array_of_one() -> None:
    content = GroupContent()
    content.add_values("parameter", {"kp": np.array([60.0])})  # type: ignore[dict-item]
    assert content.attributes == {"parameter.kp": 60.0}
    with pytest.raises(RecordingError, match=r"parameter 'kd': .* expected a number, got 'high'"):
        content.add_values("parameter", {"kd": "high"})  # type: ignore[dict-item]
