"""Numbers and truth values in a model description."""

from __future__ import annotations


def number_from(text: object) -> float | None:
    """Read a number or truth value of a model description; None where it is neither.

    Parameters
    ----------
    text : object
        Attribute of the XML, or None.
    """
    if text is None:
        return None
    if str(text).strip() in ("true", "false"):
        return 1.0 if str(text).strip() == "true" else 0.0
    try:
        return float(str(text))
    except ValueError:
        return None
