"""A user's own metrics: a Python function of a run."""

from __future__ import annotations

import hashlib
import importlib.util
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any, Self

import numpy as np

from gmfbo.errors import InputError, OwnMetricsError, did_you_mean
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
        file, _, name = label.rpartition(":")
        path = folder / file
        if not file.endswith(".py") or not name.isidentifier():
            raise InputError(f"[objective] metrics: expected \"FILE.py:FUNCTION\", got '{label}'")
        if not path.is_file():
            raise InputError(f"[objective] metrics: no file '{path}'")
        spec = importlib.util.spec_from_file_location(f"gmfbo_own_{path.stem}", path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except Exception as error:
            raise InputError(
                f"[objective] metrics: '{file}' cannot be imported: {_one_line(error)}"
            ) from error
        function = getattr(module, name, None)
        if not callable(function):
            functions = [key for key, value in vars(module).items() if callable(value)]
            raise InputError(
                f"[objective] metrics: '{file}' has no function '{name}'"
                + did_you_mean(name, functions)
            )
        return cls(label, function, required, hashlib.sha256(path.read_bytes()).hexdigest())

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
