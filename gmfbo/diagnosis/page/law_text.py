"""A law as it is written by hand: Greek letters, subscripts and powers."""

from __future__ import annotations

import re
from html import escape

_GREEK = {"tau": "τ", "omega": "ω", "phi": "φ", "mu": "μ", "pi": "π"}


def law_html(equation: str) -> str:
    """Set the text of an equation.

    Parameters
    ----------
    equation : str
        As an effect states it, such as `tau = -F_c * sign(omega)`.

    Returns
    -------
    str
        HTML; unknown parts stay as they are.
    """
    text = escape(equation)
    text = re.sub(
        r"\b([A-Za-z]+)_([A-Za-z0-9]+)\b",
        lambda m: f"{_GREEK.get(m[1], m[1])}<sub>{m[2]}</sub>",
        text,
    )
    text = re.sub(r"\b(tau|omega|phi|mu|pi)\b", lambda m: _GREEK[m[1]], text)
    text = re.sub(r"\^(-?\w+)", r"<sup>\1</sup>", text)
    return text.replace(" * ", "\u202f·\u202f").replace("-", "−").replace("&lt;=", "≤")
