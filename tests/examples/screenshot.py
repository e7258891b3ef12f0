"""README's picture, of a folder of `gmfbo diagnose`: `python -m tests.examples.screenshot DIR`."""

from __future__ import annotations

import html
import io
import re
import sys
import tempfile
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from tests.pages.headless_browser import NO_BROWSER, Browser, browser_path

IMAGES = Path(__file__).resolve().parents[2] / "notebooks" / "docs" / "images"
WIDE, HIGH = 1100, 700  # [px] of the page that is shown
COLOURS = 64  # a page of lines and text needs no more, and the file shrinks to a third
SCHEMES = {
    "light": "--blink-settings=preferredColorScheme=1",
    "dark": "--blink-settings=preferredColorScheme=0",
}


def take(report: Path, browser: Browser, scheme: str) -> bytes:
    """Take the first screen of a report.

    Parameters
    ----------
    report : Path
        A `report.html`.
    browser : Browser
        That shows it.
    scheme : {"light", "dark"}
        What the reader's system prefers.

    Returns
    -------
    bytes
        PNG with a palette; its `Description` is the headline that it shows.
    """
    page = report.read_text(encoding="utf-8")
    shot = browser.picture(page, WIDE, HIGH, SCHEMES[scheme])
    with Image.open(io.BytesIO(shot)) as picture:
        reduced = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    written = io.BytesIO()
    described = PngInfo()
    described.add_text("Description", headline_of(page))
    reduced.save(written, "PNG", optimize=True, pnginfo=described)
    return written.getvalue()


def headline_of(page: str) -> str:
    """Words of a report's first line."""
    (headline,) = re.findall(r'<h1 id="verdict">(.*?)</h1>', page, re.DOTALL)
    words = html.unescape(re.sub(r"<[^>]*>", "", headline))
    return " ".join(words.split())


if __name__ == "__main__":
    program = browser_path()
    if program is None:
        sys.exit(NO_BROWSER)
    IMAGES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        chromium = Browser(program, Path(folder))
        for name in SCHEMES:
            picture = take(Path(sys.argv[1]) / "report.html", chromium, name)
            (IMAGES / f"report-{name}.png").write_bytes(picture)
            print(f"report-{name}.png: {len(picture) / 1e3:.0f} kB")
