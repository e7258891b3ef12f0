"""A plant in Python: a function from gains and reference to a recording."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gmfbo.errors import GmfboError, NotTheGainsError
from gmfbo.recordings.columns.signal import SignalReading
from gmfbo.recordings.recording import Recording, read_recording
from gmfbo.sources.plants.failed_run import failed_run

PlantFunction = Callable[[Mapping[str, float], Recording], Any]


@dataclass(frozen=True)
class PythonPlant:
    """Calls a function once an experiment.

    Parameters
    ----------
    function : callable
        Takes the gains by name and the reference, and returns a `Recording`, the path of one, or
        arrays by name: ``{"time": ..., "position": ...}``. An exception makes a failed run.
    reading : SignalReading or None
        Tells which columns of a recorded file are signals, as a twin file does.
    """

    function: PlantFunction
    reading: SignalReading | None = None

    @property
    def name(self) -> str:
        """Name of the function, or of the object that it belongs to."""
        return str(getattr(self.function, "__name__", type(self.function).__name__))

    @property
    def content_hash(self) -> str:
        """Empty, since the behaviour of a function cannot be hashed."""
        return ""

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        """Call the function; an error becomes the status and message of the result."""
        began = time.perf_counter()
        try:
            return self._recording(self.function(dict(gains), reference))
        except NotTheGainsError:
            raise
        except GmfboError as error:
            message = str(error)
        except (Exception, SystemExit) as error:
            # A plant is foreign code: a lost connection must cost one run, not the study.
            message = repr(error)
        seconds = time.perf_counter() - began
        return failed_run(reference, f"{self.name}: {message}", name=self.name, seconds=seconds)

    def close(self) -> None:
        """Do nothing."""

    def _recording(self, result: object) -> Recording:
        if isinstance(result, Recording):
            return result
        if isinstance(result, str | Path):
            return read_recording(result, self.reading)
        if isinstance(result, Mapping) and "time" in result:
            signals = {
                str(name): np.asarray(values) for name, values in result.items() if name != "time"
            }
            return Recording(time=np.asarray(result["time"]), signals=signals, name=self.name)
        raise TypeError(
            "expected a Recording, the path of one, or arrays by name with 'time', "
            f"got {type(result).__name__}"
        )
