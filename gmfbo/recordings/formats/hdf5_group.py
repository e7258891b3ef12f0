"""An HDF5 group that holds a recording, read back as values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray


def group_content(
    group: Any, attributes: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, Any] | None]:
    """Read a group that holds `gmfbo.recordings.writing.hdf5_group.recording_content`.

    Parameters
    ----------
    group : h5py.Group
        As it was written.
    attributes : mapping
        Its attributes, read once by `dict(group.attrs)`, since that takes most of the time.

    Returns
    -------
    content : dict
        Fields of a `Recording`.
    run : dict or None
        Fields that a `Trajectory` adds, where a simulated run was written.
    """
    units: dict[str, str] = {}

    def columns(key: str) -> dict[str, NDArray[np.float64]]:
        found = {}
        for name in map(str, attributes[key]):
            dataset = group[name]
            found[name] = dataset[()]
            unit = dataset.attrs.get("unit")
            if unit is not None:
                units[name] = str(unit)
        return found

    use = attributes.get("use")
    content: dict[str, Any] = {
        "time": group["time"][()],
        "signals": columns("signals"),
        "schedules": columns("schedules"),
        "units": units,
        "parameters": with_prefix(attributes, "parameter"),
        "use": None if use is None else (float(use[0]), float(use[1])),
        **{key: str(attributes[key]) for key in ("name", "start_time", "written_by")},
    }
    if "trajectory.status" not in attributes:
        return content, None
    stopped_at = attributes.get("trajectory.stopped_at")
    return content, {
        "status": str(attributes["trajectory.status"]),
        "message": str(attributes["trajectory.message"]),
        "stopped_at": None if stopped_at is None else float(stopped_at),
        "seconds": float(attributes["trajectory.seconds"]),
    }


def is_recording_group(group: Any) -> bool:
    """Whether this group has the layout of `recording_content`."""
    return "layout" in group.attrs and "signals" in group.attrs


def with_prefix(attributes: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    """Attributes `<prefix>.<name>` by name; numbers as floats."""
    start = f"{prefix}."
    return {
        name.removeprefix(start): value if isinstance(value, str) else float(value)
        for name, value in attributes.items()
        if name.startswith(start)
    }
