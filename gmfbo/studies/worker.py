"""Run a unit on a worker, which shares nothing with the campaign but gmfbo itself."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

import gmfbo.retuning  # noqa: F401 - adds its methods
from gmfbo.errors import GmfboError
from gmfbo.studies.one_run import OneRun, make_truth
from gmfbo.studies.shelf import own_shelf
from gmfbo.studies.unit import Failed, Made, Missing, Result, Unit
from gmfbo.tuning.methods import find_method
from gmfbo.tuning.study.study import Study
from gmfbo.version import __version__


def carry_out(unit: Unit, contents: Mapping[str, bytes]) -> Result:
    """Run a unit, with contents sent before or along with it.

    Parameters
    ----------
    unit : Unit
        The unit.
    contents : mapping of str to bytes
        By hash; kept for later units.
    """
    if unit.version != __version__:
        return Failed(
            f"a worker has gmfbo {__version__}, the campaign {unit.version}; install the same on "
            "all workers"
        )
    shelf = own_shelf()
    shelf.put(contents)
    if missing := shelf.missing(unit.hashes):
        return Missing(missing)
    root = shelf.tree(unit.files.hashes, unit.files.origin)
    with tempfile.TemporaryDirectory(prefix="gmfbo-run-") as place:
        truth = Path(place) / "truth"
        truth.mkdir()
        for name, digest in unit.truth.items():
            shelf.place(digest, truth / name)
        study = unit.files.study(root, Path(place) / "run.study")
        try:
            return _made(unit, study, truth)
        except GmfboError as error:
            return Failed(" ".join(str(error).split()))
        except Exception as error:
            # A method may be foreign code: its error fails this run only, and is reported.
            return Failed(" ".join(f"{error!r}".split()))


def _made(unit: Unit, study: Study, truth: Path) -> Made:
    outcome, record = None, None
    if unit.method is None:
        make_truth(study, unit.side, truth)
    else:
        method = find_method(unit.method) if isinstance(unit.method, str) else unit.method
        outcome, record = OneRun(study, unit.key, method, truth, unit.side).run()
    new = {path.name: path.read_bytes() for path in truth.iterdir() if path.name not in unit.truth}
    return Made(outcome, new, record if unit.keep else None)
