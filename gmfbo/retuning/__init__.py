"""A diagnosis becomes IS2: the one place where tuning and diagnosis meet.

After a real run the twin's uncertain parameters and tables are estimated (`Calibration`). A
mismatch that remains is diagnosed (`complete`), and the corrected twin replaces the old one
(`PhysicsRefiner`). A twin that misleads is withdrawn (`misleads`).

Importing this package adds its methods to `gmfbo.tuning.methods.METHODS`.
"""

from __future__ import annotations

from gmfbo.retuning.corrected_methods import GMFBO_CALIBRATED, GMFBO_PHYSICS, GMFBO_SMOOTHED
from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.query.method import Method

RETUNING: tuple[Method, ...] = (GMFBO_PHYSICS, GMFBO_CALIBRATED, GMFBO_SMOOTHED)
"""Methods that this package adds."""

for _method in RETUNING:
    METHODS.setdefault(_method.name, _method)

__all__ = ["RETUNING"]
