"""A seal shows every damage, and gives one wrong bit back."""

from __future__ import annotations

import h5py
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.recordings.store.seal import mended, read_seal, sealed, without_seal

CONTENT = st.binary(min_size=1, max_size=500)


@given(content=CONTENT)
def test_a_sealed_file_is_intact_and_keeps_its_content(content: bytes) -> None:
    assert read_seal(sealed(content)).state == "intact"
    assert without_seal(sealed(content)) == content
    assert mended(sealed(content)) is None


@given(content=CONTENT)
def test_a_file_without_a_seal_says_so(content: bytes) -> None:
    assert read_seal(content).state == "absent"
    assert without_seal(content) == content
    assert mended(content) is None


@given(content=CONTENT, data=st.data())
def test_any_one_wrong_bit_of_the_content_is_found_and_turned_back(
    content: bytes, data: st.DataObject
) -> None:
    whole, damaged = sealed(content), bytearray(sealed(content))
    place = data.draw(st.integers(0, 8 * len(content) - 1))
    damaged[place // 8] ^= 1 << place % 8
    assert read_seal(bytes(damaged)).state == "damaged"
    assert mended(bytes(damaged)) == (whole, place // 8)


@given(content=CONTENT, data=st.data())
def test_a_wrong_bit_of_the_seal_itself_costs_nothing(content: bytes, data: st.DataObject) -> None:
    damaged = bytearray(sealed(content))
    place = data.draw(st.integers(8 * len(content), 8 * len(damaged) - 1))
    damaged[place // 8] ^= 1 << place % 8
    assert read_seal(bytes(damaged)).state in ("intact", "absent")


@given(content=st.binary(min_size=4, max_size=500), data=st.data())
def test_several_wrong_bits_are_damage_that_is_not_guessed_at(
    content: bytes, data: st.DataObject
) -> None:
    places = data.draw(
        st.lists(st.integers(0, 8 * len(content) - 1), min_size=2, max_size=9, unique=True)
    )
    damaged = bytearray(sealed(content))
    for place in places:
        damaged[place // 8] ^= 1 << place % 8
    assert read_seal(bytes(damaged)).state == "damaged"
    assert mended(bytes(damaged)) is None


def test_hdf5_reads_a_sealed_file_as_if_there_were_no_seal(tmp_path: object) -> None:
    file = h5py.File("x", "w", driver="core", backing_store=False)
    file["position"] = np.arange(3.0)
    file.flush()
    image = sealed(bytes(file.id.get_file_image()))
    file.close()
    with h5py.File(h5py.h5f.open_file_image(image)) as read:
        np.testing.assert_array_equal(read["position"][()], np.arange(3.0))
