"""Runs a small study until it ends or is killed; started as a program by the resume test."""

from __future__ import annotations

import sys
from pathlib import Path

from gmfbo.tuning.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis


def main(study_file: str) -> None:
    """Run or continue the study; one line of output a finished run."""
    study = Study.read(Path(study_file))
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2, friction=0.4)) as tuner:
        tuner.run(lambda event: print(event.trial, flush=True))


if __name__ == "__main__":
    main(sys.argv[1])
