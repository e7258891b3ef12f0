"""What a reader of a page sees: its text, its marked numbers, and whether its tags close."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from typing import Any, NamedTuple

VOID = ("meta", "path", "rect", "br", "circle")


class MarkedNumber(NamedTuple):
    """A number on a page that says where in `diagnosis.json` it comes from.

    Attributes
    ----------
    path : str
        Its place.
    shown : str
        Its text.
    scale : float
        That times the shown number is the number in the JSON.
    digits : int or None
        Significant ones, where zeros at the end are not.
    """

    path: str
    shown: str
    scale: float
    digits: int | None


class PageText(HTMLParser):
    """Collects text and tags; a page that is not well nested fails.

    Attributes
    ----------
    text : list of str
        Pieces of text outside style and scripts.
    tags : list of str
        Tags in order.
    attributes : list of (str, str)
        All attributes.
    numbers : list of MarkedNumber
        All that are marked.
    bare : list of str
        Text within tables outside any marked number.
    embedded : dict of str to str
        Content of each script by its id; of one without, by "".
    """

    def __init__(self, page: str) -> None:
        super().__init__()
        self.text: list[str] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.numbers: list[MarkedNumber] = []
        self.bare: list[str] = []
        self.embedded: dict[str, str] = {}
        self._open: list[tuple[str, dict[str, str]]] = []
        self.feed(page)
        self.close()
        assert not self._open, self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        known = {name: value or "" for name, value in attrs}
        self.tags.append(tag)
        self.attributes += known.items()
        if tag not in VOID:
            self._open.append((tag, known))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop()[0] == tag

    def handle_data(self, data: str) -> None:
        if not self._open:
            return
        tag, known = self._open[-1]
        if tag == "script":
            self.embedded[known.get("id", "")] = data
        elif tag != "style":
            self.text.append(data)
            self._note(tag, known, data)

    def _note(self, tag: str, known: dict[str, str], data: str) -> None:
        if tag == "data":
            digits = int(known["data-digits"]) if "data-digits" in known else None
            scale = float(known.get("data-scale", 1.0))
            self.numbers.append(MarkedNumber(known["data-path"], data, scale, digits))
        elif any(name in ("td", "th") for name, _ in self._open):
            self.bare.append(data)

    @property
    def content(self) -> Any:
        """What the page embeds of `diagnosis.json`."""
        return json.loads(self.embedded["diagnosis"])


def at_path(content: Any, path: str) -> Any:
    """Value at a place in `diagnosis.json`.

    Parameters
    ----------
    content : object
        As `json.loads` gives it.
    path : str
        Names and indices joined by dots, with a backslash before a dot within a name.
    """
    for step in re.split(r"(?<!\\)\.", path):
        name = re.sub(r"\\(.)", r"\1", step)
        content = content[int(name)] if isinstance(content, list) else content[name]
    return content


def half_a_digit(shown: str, digits: int | None) -> float:
    """Half of what the last digit of a shown number stands for."""
    mantissa, _, exponent = shown.partition("e")
    power = int(exponent or 0)
    if digits is not None:
        whole = mantissa.lstrip("-").split(".")[0]
        return 0.5 * 10.0 ** (len(whole) - digits + power)
    decimals = len(mantissa.partition(".")[2])
    return 0.5 * 10.0 ** (power - decimals)


def rounds_to(number: MarkedNumber, value: float | None) -> bool:
    """Whether a shown number is a value, rounded as it is shown."""
    if value is None:
        return number.shown == "-"
    shown = number.shown.replace("\u202f", "")
    slack = half_a_digit(shown, number.digits) * (1.0 + 1e-9)
    return abs(float(shown) - value / number.scale) <= slack
