"""Keep the state of an estimation beside a study, so that it continues after a kill."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from gmfbo.errors import StoreError
from gmfbo.files.durable import write_whole
from gmfbo.retuning.calibration import Estimate

_SLOPE = "slope_"


def keep_estimate(path: Path, estimate: Estimate) -> None:
    """Write an estimate, whole or not at all.

    Parameters
    ----------
    path : Path
        A `.npz`; its folder is made.
    estimate : Estimate
        The estimate.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    image = io.BytesIO()
    slopes = {f"{_SLOPE}{number}": slope for number, slope in estimate.slopes.items()}
    arrays: dict[str, Any] = {"x": estimate.x, "errors": estimate.errors, **slopes}
    np.savez(image, **arrays)
    write_whole(path, image.getvalue())


def read_estimate(path: Path) -> Estimate:
    """Read an estimate written by `keep_estimate`.

    Parameters
    ----------
    path : Path
        A `.npz`.

    Raises
    ------
    StoreError
        It is missing or damaged.
    """
    try:
        with np.load(path, allow_pickle=False) as kept:
            slopes = {
                int(name.removeprefix(_SLOPE)): kept[name]
                for name in kept.files
                if name.startswith(_SLOPE)
            }
            return Estimate(kept["x"], kept["errors"], slopes)
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise StoreError(
            f"{path}: cannot be read ({error}); bring it back, or give another 'out'"
        ) from None
