"""The page of `gmfbo tune --html`, written while the study runs in this process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Self

import typer

if TYPE_CHECKING:
    from gmfbo.reports.study.follower import StudyFollower
    from gmfbo.reports.study.live_file import LiveFile


class LiveStudy:
    """Keeps a page up to date, if one was asked for.

    Parameters
    ----------
    file : LiveFile or None
        The page.
    """

    def __init__(self, file: LiveFile | None) -> None:
        self._file = file
        self._follower: StudyFollower | None = None
        self._owns = True

    @classmethod
    def begin(cls, out: Path | None) -> Self:
        """Check that a page can be written, before anything of the study runs.

        Parameters
        ----------
        out : Path or None
            The page; None without one.

        Raises
        ------
        InputError
            It is no name of a page, or its folder is not there.
        """
        if out is None:
            return cls(None)
        from gmfbo.reports.study.live_file import LiveFile

        return cls(LiveFile(out))

    @contextmanager
    def following(self, folder: Path, *, owns: bool = True) -> Iterator[None]:
        """Follow a study's folder; at the end, however it comes, the page is written last.

        Parameters
        ----------
        folder : Path
            `NAME.study`, which is there.
        owns : bool
            Whether the study runs in this process, so that both end together.

        Raises
        ------
        InputError
            The page cannot be written.
        """
        if self._file is None:
            yield
            return
        from gmfbo.reports.study.follower import StudyFollower

        self._follower, self._owns = StudyFollower(folder), owns
        self._file.start(self._follower)
        try:
            yield
        finally:
            self._update(self._follower, last=True)

    def show(self) -> None:
        """Write the page anew, unless that was done a moment ago."""
        if self._follower is not None:
            self._update(self._follower, last=False)

    def _update(self, follower: StudyFollower, *, last: bool) -> None:
        if self._file is not None and (
            told := self._file.update(follower, last=last, stopped=last and self._owns)
        ):
            typer.echo(f"{told}; the study goes on without the page", err=True)
