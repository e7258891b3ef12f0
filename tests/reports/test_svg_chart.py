"""Line charts: points where the axis says, peaks kept, gaps left open."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gmfbo.reports.svg_chart import HEIGHT, WIDTH, Array, Band, Line, line_chart, thinned


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


def ticks(text: str, anchor: str) -> list[float]:
    found = re.findall(rf'text-anchor="{anchor}">([^<]+)</text>', text)
    return [float(tick) for tick in found if re.fullmatch(r"[-+.e\d]+", tick)]


def test_a_straight_line_is_drawn_straight_and_upwards() -> None:
    x = np.linspace(0.0, 2.0, 5)
    ((start, *_, end),) = drawn(chart(x, 3.0 * x))
    assert end[0] > start[0]
    assert end[1] < start[1]  # the drawing counts downwards
    points = np.array(drawn(chart(x, 3.0 * x))[0])
    assert np.abs(np.diff(points, 2, axis=0)).max() < 0.11  # coordinates have one decimal


def test_a_value_at_a_tick_lies_on_its_grid_line() -> None:
    text = chart(np.array([0.0, 1.0]), np.array([0.0, 2.0]))
    grid = re.findall(r'class="grid" d="M66 ([\d.]+)H', text)
    labels = ticks(text, "end")
    assert labels[0] == 0.0
    assert drawn(text)[0][0][1] == pytest.approx(float(grid[0]), abs=0.06)


@given(low=st.floats(-1e6, 1e6), wide=st.floats(1e-6, 1e6).map(lambda wide: wide * (1.0 + 1e-3)))
def test_ticks_are_round_apart_and_inside(low: float, wide: float) -> None:
    y = np.array([low, low + wide])
    if y[0] == y[1] or wide < 1e-9 * abs(low):
        return
    text = chart(np.array([0.0, 1.0]), y)
    labels = re.findall(r'text-anchor="end">([^<]+)</text>', text)[:-1]
    assert 2 <= len(labels) <= 12
    if wide > 1e-3 * abs(low):
        values = [float(label) for label in labels]
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
        assert all(0.0 < y < HEIGHT for _, y in points)


@given(
    y=arrays(np.float64, st.integers(1, 3000), elements=st.floats(-1e6, 1e6, width=32)),
)
def test_thinning_keeps_ends_and_extremes(y: Array) -> None:
    x = np.arange(y.size, dtype=np.float64)
    kept_x, kept_y = thinned(x, y)
    assert kept_x.size <= 802
    assert (kept_x[0], kept_x[-1]) == (x[0], x[-1])
    assert (kept_y.min(), kept_y.max()) == (y.min(), y.max())
    assert np.array_equal(y[kept_x.astype(int)], kept_y)


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
            assert all(0.0 <= a <= WIDTH and 0.0 <= b <= HEIGHT for a, b in piece)
    for left, width in re.findall(r'class="window" x="([\d.]+)" y="30" width="([\d.]+)"', text):
        assert 66.0 <= float(left) <= float(left) + float(width) <= WIDTH
