"""Start of a worker: first its channels, then the sandbox, then large or foreign code."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import sys
import threading
from pathlib import Path

from gmfbo.sources.sandbox.enclosure import enclose
from gmfbo.sources.sandbox.policy import Policy


def serve(folder: Path) -> None:
    """Serve gmfbo until it closes standard input."""
    # The FMU's prints must not mix with the answers.
    commands = os.fdopen(os.dup(0), "r", encoding="utf-8")
    if sys.platform == "win32":
        _remove_when_parent_is_gone(folder)
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    first = json.loads(commands.readline() or "null")
    if first is not None:
        work = Path(first["work"])
        os.chdir(work)
        os.environ["TMPDIR"] = os.environ["TEMP"] = os.environ["TMP"] = str(work)
        own = [work, *(Path(fmu["folder"]) for fmu in first["fmus"])]
        enclosure = enclose(
            Policy.from_json(first["policy"]), own=own, shared=[Path(first["arrays"]).parent]
        )
        from gmfbo.sources.worker.worker_main import Worker

        with contextlib.suppress(BrokenPipeError):
            Worker(first, commands, answers, work).serve(enclosure.missing)
    os._exit(0)  # past the FMU's own clean-up, which may hang


if sys.platform == "win32":

    def _remove_when_parent_is_gone(folder: Path) -> None:
        """Remove the folder and end this process, even while a native call hangs: from a thread."""
        import psutil

        parent = os.getppid()

        def watch() -> None:
            with contextlib.suppress(psutil.NoSuchProcess):
                psutil.Process(parent).wait()
            os.chdir(folder.parent)  # Windows removes no folder that a process works in
            shutil.rmtree(folder, ignore_errors=True)
            os._exit(0)

        threading.Thread(target=watch, daemon=True).start()
