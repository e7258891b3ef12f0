"""Settings that hold for the whole test run."""

from __future__ import annotations

import os

# Before NumPy and torch load: see gmfbo/__init__.py.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from hypothesis import settings  # noqa: E402

import gmfbo.retuning  # noqa: E402, F401 - all methods are listed before tests are collected

settings.register_profile("gmfbo", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("gmfbo")
