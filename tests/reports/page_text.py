"""What a reader of a page sees: its text, and whether its tags close."""

from __future__ import annotations

from html.parser import HTMLParser

VOID = ("meta", "path", "rect", "br")


class PageText(HTMLParser):
    """Collects text and tags; a page that is not well nested fails.

    Attributes
    ----------
    text : list of str
        Pieces of text outside the style.
    tags : list of str
        Tags in order.
    attributes : list of (str, str)
        All attributes.
    """

    def __init__(self, page: str) -> None:
        super().__init__()
        self.text: list[str] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self._open: list[str] = []
        self.feed(page)
        self.close()
        assert not self._open, self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] != "style":
            self.text.append(data)
