"""Line charts: points where the axis says, peaks kept, gaps left open."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gmfbo.pages.svg_axis import Array
from gmfbo.pages.svg_chart import Band, Line, line_chart
from gmfbo.pages.svg_frame import HIGH, WIDE
from gmfbo.pages.thinning import thinned_rows


def chart(x: Array, y: Array, **more: object) -> str:
    return line_chart(
        [Line("line", "after", x, y)],
        title="title",
        x_label="time [s]",
        y_label="position [rad]",
        **more,  # type: ignore[arg-type]
    )


def drawn(text: str, style: str = "line after") -> list[list[tuple[float, float]]]:
    """Pieces of a line as drawn, in the drawing's units."""
    (path,) = re.findall(rf'class="{style}" d="([^"]+)"', text)
    return [
        [(float(x), float(y)) for x, y in (point.split() for point in piece.split("L"))]
        for piece in path.rstrip("Z").lstrip("M").split("M")
    ]


def y_ticks(text: str) -> list[tuple[float, float]]:
    """Place in the drawing and value of each number beside the y axis."""
    found = re.findall(r'class="y-tick" x="-8" dy="4" y="([\d.]+)%">([^<]+)<', text)
    return [(float(share) / 100.0 * HIGH, float(value)) for share, value in found]


def test_a_straight_line_is_drawn_straight_and_upwards() -> None:
    x = np.linspace(0.0, 2.0, 5)
    ((start, *_, end),) = drawn(chart(x, 3.0 * x))
    assert end[0] > start[0]
    assert end[1] < start[1]  # the drawing counts downwards
    points = np.array(drawn(chart(x, 3.0 * x))[0])
    assert np.abs(np.diff(points, 2, axis=0)).max() <= 2.0  # coordinates are whole


def test_a_value_at_a_tick_lies_beside_its_number() -> None:
    text = chart(np.array([0.0, 1.0]), np.array([0.0, 2.0]))
    (place, value), *_ = y_ticks(text)
    assert value == 0.0
    assert drawn(text)[0][0][1] == pytest.approx(place, abs=0.6)


def test_the_ends_of_the_axes_are_told_to_the_script() -> None:
    text = chart(np.array([2.0, 5.0]), np.array([0.0, 1.0]))
    assert 'data-x="2 5" data-y="-0.05 1.05"' in text


@given(low=st.floats(-1e6, 1e6), wide=st.floats(1e-6, 1e6).map(lambda wide: wide * (1.0 + 1e-3)))
def test_ticks_are_round_apart_and_inside(low: float, wide: float) -> None:
    y = np.array([low, low + wide])
    if y[0] == y[1] or wide < 1e-9 * abs(low):
        return
    ticks = y_ticks(chart(np.array([0.0, 1.0]), y))
    assert 2 <= len(ticks) <= 12
    if wide > 1e-3 * abs(low):
        values = [value for _, value in ticks]
        assert all(np.diff(values) > 0.0)
        assert values[0] >= low - 0.1 * wide
        assert values[-1] <= low + 1.1 * wide


def test_a_gap_interrupts_the_line() -> None:
    y = np.array([0.0, 1.0, np.nan, 1.0, 0.0])
    assert [len(piece) for piece in drawn(chart(np.arange(5.0), y))] == [2, 2]


def test_a_line_without_points_and_a_constant_line_are_drawn() -> None:
    x = np.arange(3.0)
    assert 'class="line after"' not in chart(x, np.full(3, np.nan))
    for value in (0.0, 5.0, -3e-9):
        (points,) = drawn(chart(x, np.full(3, value)))
        assert all(0.0 < y < HIGH for _, y in points)


@given(
    y=arrays(np.float64, st.integers(1, 3000), elements=st.floats(-1e6, 1e6, width=32)),
    buckets=st.integers(1, 400),
)
def test_thinning_keeps_ends_and_extremes(y: Array, buckets: int) -> None:
    rows = thinned_rows([y], buckets)
    assert rows.size <= 2 * buckets + 2
    assert (rows[0], rows[-1]) == (0, y.size - 1)
    assert np.all(np.diff(rows) > 0)
    assert (y[rows].min(), y[rows].max()) == (y.min(), y.max())


def test_thinning_keeps_the_extremes_of_each_column_beside_what_is_not_there() -> None:
    y, other = np.zeros(5000), np.zeros(5000)
    y[1234], y[100:900], other[4321] = 1.0, np.nan, -1.0
    rows = thinned_rows([y, other], 50)
    assert {1234, 4321} <= set(rows.tolist())


@given(
    y=arrays(np.float64, 20, elements=st.floats(-1e9, 1e9)),
    start=st.floats(-5.0, 25.0),
    wide=st.floats(0.0, 10.0),
)
def test_everything_stays_inside_the_drawing(y: Array, start: float, wide: float) -> None:
    text = chart(
        np.arange(20.0), y, band=Band(np.arange(20.0), y - 1.0, y + 1.0),
        windows=[(start, start + wide)],
    )  # fmt: skip
    for style in ("line after", "band"):
        for piece in drawn(text, style):
            for x, height in piece:
                assert -0.5 <= x <= WIDE + 0.5
                assert -0.5 <= height <= HIGH + 0.5
    for x, width in re.findall(r'class="window" x="([\d.]+)" y="0" width="([\d.]+)"', text):
        assert 0.0 <= float(x) <= WIDE
        assert float(width) >= 6.0
