"""A self-contained page: style, tables and sections as HTML text, every value escaped."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

# Colours of Okabe and Ito (2008), apart for every kind of colour vision; dashes tell them apart
# in print. The page needs no network and no script.
STYLE = """
:root{color-scheme:light dark;--ink:#1b1e23;--soft:#5b6470;--paper:#fff;--panel:#f4f6f8;
--rule:#d5dae0;--recorded:#1b1e23;--nominal:#8a929c;--before:#c04f00;--after:#0072b2;
--band:#0072b2;--window:#e69f00}
@media (prefers-color-scheme:dark){:root{--ink:#e8eaed;--soft:#a3acb8;--paper:#14171b;
--panel:#1d2127;--rule:#353b44;--recorded:#e8eaed;--nominal:#7d8794;--before:#f0a04b;
--after:#56b4e9;--band:#56b4e9;--window:#e69f00}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:76rem;padding:1.5rem 1rem 3rem;background:var(--paper);
color:var(--ink);font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
h1{font-size:1.4rem;line-height:1.35;max-width:56rem;margin:.2rem 0 1rem;text-wrap:pretty}
h2{font-size:1.2rem;margin:2.2rem 0 .6rem;padding-top:.6rem;border-top:1px solid var(--rule)}
h3{font-size:1.05rem;margin:1.4rem 0 .4rem}
p{margin:.4rem 0 .8rem;max-width:46rem}
.soft{color:var(--soft)}
code{font:.92em ui-monospace,Consolas,monospace;overflow-wrap:anywhere}
.scroll{overflow-x:auto;margin:.4rem 0 1rem}
table{border-collapse:collapse;font-size:.94rem}
caption{text-align:left;color:var(--soft);padding-bottom:.3rem}
th,td{padding:.32rem .9rem .32rem 0;border-bottom:1px solid var(--rule);text-align:left;
vertical-align:top}
th{font-weight:600}
.number{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
th.number{white-space:normal;vertical-align:bottom}
.charts{display:grid;align-items:end;gap:1rem 1.5rem;
grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr))}
figure{margin:0;min-width:0}
figcaption{font-size:.94rem;color:var(--soft)}
.chart{display:block;width:100%;max-width:42rem;height:auto;font-size:14px}
.chart text{fill:var(--soft)}
.chart .label{fill:var(--ink)}
.grid{stroke:var(--rule);fill:none}
.axis{stroke:var(--soft);fill:none}
.line{fill:none;stroke-width:1.8;stroke-linejoin:round}
.recorded{stroke:var(--recorded);stroke-width:2.6;opacity:.55}
.nominal{stroke:var(--nominal);stroke-dasharray:2 4}
.before{stroke:var(--before);stroke-dasharray:7 4}
.after{stroke:var(--after)}
.band{fill:var(--band);opacity:.2}
.window{fill:var(--window);opacity:.28}
.legend{list-style:none;display:flex;flex-wrap:wrap;gap:.1rem .8rem;margin:.2rem 0 .6rem;
padding:0;font-size:.88rem}
.legend svg{width:34px;height:10px;margin-right:.4rem}
details{margin:.6rem 0}
summary{cursor:pointer}
.facts{background:var(--panel);border-radius:6px;padding:.7rem 1rem;font-size:.94rem}
@media (max-width:40rem){h1{font-size:1.15rem}body{padding-top:.8rem}
th,td{padding-right:.55rem}table{font-size:.86rem}}
@media print{details>*{display:block}}
"""


def page(title: str, body: str) -> str:
    """Put a body into a page of its own.

    Parameters
    ----------
    title : str
        Text of the title.
    body : str
        HTML.

    Returns
    -------
    str
        The whole page; it loads nothing.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head>\n"
        f"<body>\n{body}\n</body></html>\n"
    )


def section(heading: str, *parts: str) -> str:
    """Put HTML under a heading; nothing at all where there is none.

    Parameters
    ----------
    heading : str
        Text.
    *parts : str
        HTML; empty ones are left out.

    Returns
    -------
    str
        A `<section>` element, or nothing.
    """
    shown = [part for part in parts if part]
    if not shown:
        return ""
    return f"<section><h2>{escape(heading)}</h2>\n" + "\n".join(shown) + "\n</section>"


def paragraph(text: str, style: str = "") -> str:
    """Text as a paragraph; nothing for no text."""
    if not text:
        return ""
    return f'<p class="{style}">{escape(text)}</p>' if style else f"<p>{escape(text)}</p>"


def table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: Sequence[int] = (),
    caption: str = "",
) -> str:  # fmt: skip
    """Draw a table of texts; nothing without rows.

    Parameters
    ----------
    heads : sequence of str
        Column heads.
    rows : sequence of sequence of str
        Cells as text.
    numbers : sequence of int
        Columns to set as numbers.
    caption : str
        Text above it.

    Returns
    -------
    str
        A table that scrolls sideways on a narrow screen.
    """
    if not rows:
        return ""

    def row(kind: str, cells: Sequence[str]) -> str:
        return "".join(
            f"<{kind}{' class=number' if column in numbers else ''}>{escape(cell)}</{kind}>"
            for column, cell in enumerate(cells)
        )

    told = f"<caption>{escape(caption)}</caption>" if caption else ""
    body = "".join(f"<tr>{row('td', cells)}</tr>" for cells in rows)
    return (
        f'<div class="scroll"><table>{told}<thead><tr>{row("th", heads)}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )
