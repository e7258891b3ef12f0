"""What the diagnosis would gain if it tried the right law: tells a search's fault from a budget's.

    python -m tests.blind.truth_in_engine --out FOLDER CASE...

For cases whose diagnosis is done and whose answers are open. The engine's own noise budget scores
the library's law with the true values, at the truth and after a fit from there. Large gains that
the diagnosis did not find were lost by its search; small ones by what it takes for noise.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

from gmfbo import FmuTwin, Recording
from gmfbo.diagnosis.engine import _aligned_case
from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.misfit import chi2
from gmfbo.physics import CATALOGUE
from tests.blind.generate import answer_path


def lines(out: Path, case: str) -> Iterator[str]:
    """What the truth gains in one case, a line each.

    Parameters
    ----------
    out : Path
        Folder of the benchmark.
    case : str
        Its number.
    """
    answer = json.loads(answer_path(out, int(case)).read_text(encoding="utf-8"))
    place = out / "cases" / case
    hidden = [entry for entry in answer["effects"] if entry["name"] in CATALOGUE]
    yield f"{case} {answer['machine']}: " + ", ".join(
        f"{entry['name']} (oracle {entry['added_gain']:.0f})" for entry in answer["effects"]
    )
    if not hidden:
        return
    with FmuTwin(place / "twin.toml") as twin:
        recordings = [Recording.read(path, twin) for path in sorted(place.glob("rec*.csv"))]
        opened = _aligned_case(twin, recordings, 0, 1)
        with closing(opened.simulations):
            candidates = tuple(
                Candidate(entry["name"], started(entry, opened.setting.excitation))
                for entry in hidden
            )
            law = replace(opened.base.hypothesis, effects=candidates)
            true = {name: value["true"] for name, value in answer["parameters"].items()}
            for name, values in (("true", true), ("refitted", opened.base.parameters)):
                start = law.start(values)
                run = opened.simulations.run([law.point(start)])[0]
                at_start = opened.base.chi2 - chi2(opened.misfit.residual(run))
                fitted = fit(opened.misfit, law, values, parallel=True)
                if fitted is None:
                    yield f"  {name} parameters: gain {at_start:.0f}, no fit"
                    continue
                found = [dict(effect.values) for effect in fitted.hypothesis.effects]
                yield (
                    f"  {name} parameters: gain {at_start:.0f}, fitted "
                    f"{opened.base.chi2 - fitted.chi2:.0f} with {found}"
                )


def started(entry: Mapping[str, Any], excitation: Any) -> dict[str, float]:
    """True values over the library's own start, which has what the truth does not name."""
    starts = list(CATALOGUE[entry["name"]].starts(excitation)) or [{}]
    return {**starts[len(starts) // 2], **entry["values"]}


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("--out", type=Path, required=True)
    asked.add_argument("cases", nargs="+")
    options = asked.parse_args()
    for case in options.cases:
        for line in lines(options.out, case):
            print(line, flush=True)


if __name__ == "__main__":
    main()
