"""The control loop as a drawing, with the parts marked in which the mismatch sits."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from html import escape
from typing import NamedTuple


class _Block(NamedTuple):
    x: float
    y: float


# Forward path above from left to right, feedback below from right to left: it fits a phone.
_WIDE, _HIGH = 112.0, 40.0
_BLOCKS: Mapping[str, _Block] = {
    "controller": _Block(118.0, 24.0),
    "actuator": _Block(262.0, 24.0),
    "plant": _Block(336.0, 112.0),
    "transmission": _Block(192.0, 112.0),
    "sensor": _Block(48.0, 112.0),
}
_WIRES = (
    ((20.0, 44.0), (62.0, 44.0)),
    ((84.0, 44.0), (118.0, 44.0)),
    ((230.0, 44.0), (262.0, 44.0)),
    ((374.0, 44.0), (418.0, 44.0), (418.0, 112.0)),
    ((336.0, 132.0), (304.0, 132.0)),
    ((192.0, 132.0), (160.0, 132.0)),
    ((73.0, 112.0), (73.0, 55.0)),
)


def loop_drawing(guilty: Collection[str], labels: Mapping[str, Sequence[str]]) -> str:
    """Draw reference, controller, actuator, plant, transmission and sensor as a loop.

    Parameters
    ----------
    guilty : collection of str
        Parts that are marked.
    labels : mapping of str to sequence of str
        By part: short lines of what is missing there.

    Returns
    -------
    str
        An `<svg>` element.
    """
    told = f", {' and '.join(guilty)} marked" if guilty else ""
    parts = [
        '<svg class="loop" viewBox="0 0 470 196" role="img" '
        f'aria-label="{escape(f"control loop{told}")}">',
        '<text class="told start" x="2" y="24">reference</text>'
        '<circle class="block" cx="73" cy="44" r="11"/>'
        '<text class="told" x="57" y="38">+</text><text class="told" x="85" y="68">−</text>',
        *(_wire(points) for points in _WIRES),
        *(_block(name, name in guilty, labels.get(name, ())) for name in _BLOCKS),
        "</svg>",
    ]
    return "".join(parts)


def _wire(points: Sequence[tuple[float, float]]) -> str:
    (x0, y0), (x, y) = points[-2:]
    drawn = "L".join(f"{a:g} {b:g}" for a, b in points)
    dx = (x > x0) - (x < x0)
    dy = (y > y0) - (y < y0)
    tip = f"M{x:g} {y:g}l{-8 * dx - 4 * dy:g} {-8 * dy - 4 * dx:g}l{8 * dy:g} {8 * dx:g}Z"
    return f'<path class="wire" d="M{drawn}"/><path class="tip" d="{tip}"/>'


def _block(name: str, guilty: bool, labels: Sequence[str]) -> str:
    place = _BLOCKS[name]
    middle = place.x + 0.5 * _WIDE
    # Above the upper blocks there is no room for more than one line.
    below = place.y + _HIGH + 17.0
    lines = "".join(
        f'<text class="told" x="{middle:g}" y="{below + 15.0 * k:g}">{escape(label)}</text>'
        for k, label in enumerate(labels)
    )
    style = ' class="guilty"' if guilty else ""
    return (
        f'<g{style}><rect class="block" x="{place.x:g}" y="{place.y:g}" width="{_WIDE:g}" '
        f'height="{_HIGH:g}" rx="5"/>'
        f'<text x="{middle:g}" y="{place.y + 25:g}">{name}</text>{lines}</g>'
    )
