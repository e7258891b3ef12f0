"""Keep the page of a running study up to date on the disk."""

from __future__ import annotations

import time
from pathlib import Path

from gmfbo.errors import InputError
from gmfbo.files.durable import cause, write_whole
from gmfbo.reports.study.follower import StudyFollower
from gmfbo.reports.study.live_page import live_page, waiting_page

_LEAST_S = 2.0  # between two pages: the browser looks every five seconds
_SHARE = 0.05  # of the time that drawing the page may take from the study


class LiveFile:
    """Page of a running study, written anew as runs come in.

    Parameters
    ----------
    out : Path
        Page to write; an older one is replaced.

    Raises
    ------
    InputError
        The name does not end in .html, or its folder is not there.
    """

    def __init__(self, out: Path) -> None:
        if out.suffix.lower() not in (".html", ".htm"):
            raise InputError(f"--html: expected a file name that ends in .html, got '{out}'")
        if not out.parent.is_dir():
            raise InputError(f"--html: expected a folder '{out.parent}'; make it first")
        self.out = out
        self._told = False
        self._next = 0.0
        self._left: float | None = None

    def start(self, follower: StudyFollower) -> None:
        """Write a first page.

        Parameters
        ----------
        follower : StudyFollower
            Of the study's folder.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        try:
            write_whole(self.out, waiting_page(follower.file.name).encode(), durable=False)
        except OSError as error:
            raise InputError(f"--html: cannot write '{self.out}': {cause(error)}") from None

    def update(self, follower: StudyFollower, *, last: bool = False, stopped: bool = False) -> str:
        """Read what is new and write the page, unless that was done a moment ago.

        Parameters
        ----------
        follower : StudyFollower
            Of the study's folder.
        last : bool
            Whether nothing comes after it: the page is written in any case.
        stopped : bool
            Whether the study's process ends, so that the page need not reload.

        Returns
        -------
        str
            What to tell the user: once, that the page could not be written. The study goes on
            without it.
        """
        began = time.monotonic()
        if not last and began < self._next:
            return ""
        steps = follower.news()
        if steps:
            self._left = steps[-1].seconds_left
        trouble = self._write(follower, stopped)
        self._next = time.monotonic() + max(_LEAST_S, (time.monotonic() - began) / _SHARE)
        if self._told:
            return ""
        self._told = bool(trouble)
        return trouble

    def _write(self, follower: StudyFollower, stopped: bool) -> str:
        review, state = follower.review, follower.state
        if not review.runs:
            return ""
        if stopped and state == "running":
            state = "interrupted"
        try:
            write_whole(self.out, live_page(review, state, self._left).encode(), durable=False)
        except OSError as error:
            return f"--html: cannot write '{self.out}': {cause(error)}"
        return ""
