"""A user's own metrics: a Python function of a run."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any, Self

import numpy as np

from gmfbo.errors import OwnMetricsError
from gmfbo.files.user_function import load_function
from gmfbo.objective.metrics import METRICS
from gmfbo.recordings.recording import Recording


@dataclass(frozen=True)
class OwnMetrics:
    """Metrics by a function of the user, from a run of one reference.

    Attributes
    ----------
    label : str
        `mine.py:function`, for messages.
    function : callable
        Takes a `Recording`, returns a mapping of names to numbers, or one number, which gets
        the function's name. Smaller is better.
    required : frozenset of str
        Names that it must return.
    content_hash : str
        Hash of its file.
    """

    label: str
    function: Callable[[Recording], Any]
    required: frozenset[str] = frozenset()
    content_hash: str = ""

    @classmethod
    def load(cls, label: str, folder: Path, required: frozenset[str] = frozenset()) -> Self:
        """Load the function from its file.

        Parameters
        ----------
        label : str
            `FILE.py:FUNCTION`.
        folder : Path
            Folder to which the path is relative.
        required : frozenset of str
            Names that the function must return.

        Raises
        ------
        InputError
            There is no such file or function, or the file cannot be imported.
        """
        function = load_function(label, folder, "[objective] metrics")
        content = (folder / label.rpartition(":")[0]).read_bytes()
        return cls(label, function, required, hashlib.sha256(content).hexdigest())

    def of(self, run: Recording) -> dict[str, float]:
        """Metrics of a run that succeeded.

        Parameters
        ----------
        run : Recording
            Of one reference, with all signals that were recorded.

        Raises
        ------
        OwnMetricsError
            The function raised, or returned anything but finite numbers by name.
        """
        try:
            returned = self.function(run)
        except Exception as error:
            raise OwnMetricsError(f"metrics {self.label}: {_one_line(error)}") from error
        values = (
            dict(returned)
            if isinstance(returned, Mapping)
            else {self.label.rpartition(":")[2]: returned}
        )
        for name, value in values.items():
            if name in METRICS or "[" in str(name):
                raise OwnMetricsError(
                    f"metrics {self.label}: expected names of its own, got '{name}'"
                )
            if not isinstance(value, Real) or not np.isfinite(float(value)):
                raise OwnMetricsError(
                    f"metrics {self.label}: expected a finite number for '{name}', got {value!r}"
                )
        for name in sorted(self.required - set(values)):
            raise OwnMetricsError(
                f"metrics {self.label}: expected '{name}' in what it returns, "
                f"got {', '.join(values) or 'nothing'}"
            )
        return {str(name): float(value) for name, value in values.items()}


def _one_line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
