"""On Windows, notice the end of the parent process even while a native call hangs."""

from __future__ import annotations

import os
import shutil
import sys
import threading
from pathlib import Path

if sys.platform == "win32":

    def remove_when_parent_is_gone(folder: Path) -> None:
        """Remove a folder and end this process, from a thread, once the parent has ended.

        Parameters
        ----------
        folder : Path
            Private folder of the twin.
        """
        parent = os.getppid()

        def watch() -> None:
            _wait_for_end(parent)
            os.chdir(folder.parent)  # Windows cannot remove the working folder of a process
            shutil.rmtree(folder, ignore_errors=True)
            os._exit(0)

        threading.Thread(target=watch, daemon=True).start()

    def _wait_for_end(parent: int) -> None:
        import ctypes

        synchronize, forever = 0x00100000, 0xFFFFFFFF
        kernel = ctypes.WinDLL("kernel32", use_last_error=True)
        kernel.OpenProcess.restype = ctypes.c_void_p
        handle = ctypes.c_void_p(kernel.OpenProcess(synchronize, False, parent))
        kernel.WaitForSingleObject(handle, forever)
