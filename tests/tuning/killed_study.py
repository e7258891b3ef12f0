"""Runs a small study until it ends or is killed; started as a program by the resume test."""

from __future__ import annotations

import sys
from pathlib import Path

from gmfbo.interrupt import remembered_interrupt, unwrapped_interrupt
from gmfbo.tuning.query.progress import Progress
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis
from tests.tuning.methods.quick_methods import QUICK


def main(study_file: str) -> None:
    """Run or continue the study; one line of output a finished run."""
    study = Study.read(Path(study_file))
    twin = AnalyticAxis(inertia=0.2, friction=0.4)
    method = QUICK[study.file.method]
    with (
        unwrapped_interrupt(),
        remembered_interrupt() as pressed,
        Tuner(study, is1=AnalyticAxis(), is2=twin, method=method, resume=True) as tuner,
    ):

        def tell(event: Progress) -> None:
            print(event.trial, flush=True)
            if pressed.is_set():
                raise KeyboardInterrupt

        tuner.run(tell)


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except KeyboardInterrupt:
        sys.exit(130)
