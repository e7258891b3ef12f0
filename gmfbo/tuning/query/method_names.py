"""Names of the tuning methods, without loading the methods and torch."""

METHOD_NAMES = (
    "gmfbo",
    "gmfbo_kernel",
    "gmfbo_paper",
    "mfbo_adaptive",
    "mfbo_icm",
    "mfbo_caei",
    "mfbo_takg",
    "rmfbo",
    "bo_ei",
    "twin_once",
    "random",
    "gmfbo_physics",
    "gmfbo_calibrated",
    "gmfbo_smoothed",
)
"""Names of gmfbo's own methods."""

ADDED_GROUP = "gmfbo.methods"
"""Entry-point group by which installed packages add methods."""
