"""A Chromium without a window that opens a page and tells what came of it."""

from __future__ import annotations

import html
import json
import os
import re
import shutil
import subprocess
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
NO_BROWSER = (
    "no Chromium found: put one on PATH ('apt-get install chromium') or its path into GMFBO_BROWSER"
)
# Nothing but the file may be reached: names resolve to nothing, and addresses to a closed port.
_OFFLINE = ("--host-resolver-rules=MAP * ~NOTFOUND", "--proxy-server=127.0.0.1:9")
_QUIET = (
    "--headless",
    "--disable-gpu",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--hide-scrollbars",
)
_LISTEN = """<script>
window.complaints = [];
addEventListener("error", (event) => complaints.push(String(event.message)));
const console_error = console.error;
console.error = (...words) => { complaints.push(words.join(" ")); console_error(...words); };
</script>"""
_TELL = """<script>
addEventListener("load", () => {
  const box = (name) => {
    const found = document.querySelector(name);
    if (!found) return null;
    const r = found.getBoundingClientRect();
    return [r.left, r.top, r.right, r.bottom];
  };
  let told;
  try { told = (() => { %s })(); } catch (error) { complaints.push(String(error)); }
  const loaded = performance.getEntriesByType("resource").map((one) => one.name);
  const answer = document.createElement("pre");
  answer.id = "answer";
  answer.textContent = JSON.stringify({told, loaded, complaints});
  document.body.replaceChildren(answer);
});
</script>"""


@dataclass(frozen=True)
class Browser:
    """A Chromium of this machine.

    Attributes
    ----------
    path : Path
        Its program.
    folder : Path
        For its profile and the pages that it opens.
    """

    path: Path
    folder: Path

    def ask(self, page: str, question: str, wide: int, high: int) -> dict[str, Any]:
        """Open a page and run a function body on it.

        Parameters
        ----------
        page : str
            HTML.
        question : str
            JavaScript that returns something; `box(selector)` gives left, top, right and bottom.
        wide, high : int
            [px] Size of the screen.

        Returns
        -------
        dict
            `told` is what the question returned, `loaded` what was fetched, and `complaints` are
            errors of the page.
        """
        asked = page.replace("<head>", f"<head>{_LISTEN}", 1)
        asked = asked.replace("</body>", _TELL.replace("%s", question) + "</body>")
        done = self._run(asked, wide, high, "--dump-dom", "--enable-logging=stderr")
        found = re.search(r'<pre id="answer">(.*?)</pre>', done.stdout, re.DOTALL)
        assert found is not None, done.stderr[-2000:]
        answer: dict[str, Any] = json.loads(html.unescape(found[1]))
        answer["complaints"] += re.findall(r"CONSOLE\S* (.*)", done.stderr)
        return answer

    def loads_again(self, page: str, most: float) -> bool:
        """Open a page, and wait until it loads itself a second time.

        Parameters
        ----------
        page : str
            HTML.
        most : float
            [s] Time after which it counts as one that does not.
        """
        said = "<script>console.error('loaded here');</script></body>"
        command = self._command(page.replace("</body>", said), 1280, 800)
        # Some port of its own keeps the browser open; nobody connects to it.
        options = ("--enable-logging=stderr", "--remote-debugging-port=0")
        count = 0
        with subprocess.Popen(
            [*command[:-1], *options, command[-1]], stderr=subprocess.PIPE, text=True
        ) as process:
            ending = threading.Timer(most, process.kill)
            ending.start()
            assert process.stderr is not None
            for line in process.stderr:
                count += "loaded here" in line and "CONSOLE" in line
                if count == 2:
                    break
            ending.cancel()
            process.kill()
        return count == 2

    def opened(self, page: Path) -> str:
        """HTML of a page that lies beside its scripts, after these had time to draw.

        Parameters
        ----------
        page : Path
            Opened where it lies.
        """
        *command, _ = self._command("", 1280, 800)
        done = subprocess.run(
            [*command, "--dump-dom", "--virtual-time-budget=10000", page.resolve().as_uri()],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=90,
            check=True,
        )
        return done.stdout

    def picture(self, page: str, wide: int, high: int, *options: str) -> bytes:
        """Take a screenshot.

        Parameters
        ----------
        page : str
            HTML.
        wide, high : int
            [px] Size of the screen.
        *options : str
            Of the browser.

        Returns
        -------
        bytes
            PNG.
        """
        target = self.folder / "screen.png"
        target.unlink(missing_ok=True)
        self._run(page, wide, high, f"--screenshot={target}", *options)
        return target.read_bytes()

    def _run(
        self, page: str, wide: int, high: int, *options: str
    ) -> subprocess.CompletedProcess[str]:
        *command, opened = self._command(page, wide, high)
        return subprocess.run(
            [*command, *options, opened],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=90,
            check=True,
        )

    def _command(self, page: str, wide: int, high: int) -> list[str]:
        """Write the page, and name program, options and page."""
        opened = self.folder / "page.html"
        opened.write_text(page, encoding="utf-8")
        # A sandbox of its own is refused to root and in most containers; the page is ours.
        command = [str(self.path), *_QUIET, *_OFFLINE, "--no-sandbox"]
        command += [f"--user-data-dir={self.folder / 'profile'}", f"--window-size={wide},{high}"]
        return [*command, opened.as_uri()]


def browser_path() -> Path | None:
    """The Chromium that GMFBO_BROWSER names, else one on PATH; None without one."""
    named = os.environ.get("GMFBO_BROWSER")
    found = shutil.which(named) if named else next(filter(None, map(shutil.which, NAMES)), None)
    return Path(found) if found else None
