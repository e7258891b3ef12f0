"""Parse numbers of one column: decimal comma and thousands separators."""

from __future__ import annotations

import re

_POINT = re.compile(r"\d\.|\.\d")
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[.' \u00a0\u202f]\d{3})+(?:,\d+)?")
_SURE = re.compile(r"[+-]?\d{1,3}(?:\.\d{3})+,\d+")  # 1.234,5 is unambiguous
_SEPARATORS = re.compile(r"[.' \u00a0\u202f]")


def with_point(texts: list[str], delimiter: str, dialect: str) -> list[str]:
    """Numbers with a decimal point; other texts stay unchanged.

    Parameters
    ----------
    texts : list of str
        Cells of one column.
    delimiter : str
        Between cells. If it is a comma, a comma inside a cell was quoted, and only the dialect
        `decimal_comma` tells whether it separates thousands.
    dialect : str
        One of `gmfbo.recordings.columns.column_mapping.DIALECTS`.
    """
    if dialect != "decimal_comma" and "," not in "".join(texts):
        return texts  # the usual column: nothing in it can be a decimal comma
    if dialect == "decimal_comma" or _surely_comma(texts):
        return [_from_comma(text) for text in texts]
    # A comma beside points may separate thousands: that cell is no number.
    if delimiter != "," and not any(map(_POINT.search, texts)):
        return [text.replace(",", ".") for text in texts]
    return texts


def _surely_comma(texts: list[str]) -> bool:
    dotted = [text for text in texts if _POINT.search(text)]
    return any(map(_SURE.fullmatch, dotted)) and all(map(_THOUSANDS.fullmatch, dotted))


def _from_comma(text: str) -> str:
    if _THOUSANDS.fullmatch(text):
        text = _SEPARATORS.sub("", text)
    # A point that separates no thousands is a mistake, not a decimal point.
    return f"{text}?" if "." in text else text.replace(",", ".")
