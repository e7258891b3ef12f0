"""A diagnosis becomes IS2: the one place where tuning and diagnosis meet.

After a real run the twin's uncertain parameters and tables are estimated (`Calibration`), and where
these do not suffice, the diagnosis is asked (`complete`), or the usual physics is estimated with
them (`with_usual_physics`). The corrected twin replaces the old one (`PhysicsRefiner`). A twin
that misleads is withdrawn (`misleads`).

Importing this package adds its methods to `gmfbo.tuning.methods.METHODS`.
"""

from __future__ import annotations

from gmfbo.tuning.methods import METHODS

RETUNING = {
    "gmfbo_physics": "gmfbo.retuning.corrected_methods:GMFBO_PHYSICS",
    "gmfbo_estimated": "gmfbo.retuning.corrected_methods:GMFBO_ESTIMATED",
    "gmfbo_calibrated": "gmfbo.retuning.corrected_methods:GMFBO_CALIBRATED",
    "identify_then_optimise": "gmfbo.retuning.corrected_methods:IDENTIFY_THEN_OPTIMISE",
}
"""Rows that this package adds to the table of methods."""

METHODS.add_rows(RETUNING)

__all__ = ["RETUNING"]
