"""How what was told compares with the true law: errors, sets and widths of a registered draw.

python -m tests.blind.draw.against_the_true_law OUTCOMES.jsonl --seed SEED --to RESULT.jsonl

Writes a line for each case, goes on where it was stopped, and prints the table. Plants, experiments
and recordings are drawn again from seed and answer, so that no folder of cases is needed. Where the
plant's source has changed since the draw, `--plant` names the source of that time.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind import truth
from tests.blind.draw.errors_of_the_true_law import errors_of, joint_ratio, told_errors
from tests.blind.draw.fit_of_the_true_law import TrueLaw
from tests.blind.draw.judging import Judged, claims_of, judge
from tests.blind.draw.law_coordinates import coordinates
from tests.blind.draw.narrowest_intervals import narrowest
from tests.blind.draw.nulls import VARIANTS
from tests.blind.draw.outcomes import drop_cut_line, read_outcomes, tell
from tests.blind.draw.remade import Columns, Remade, remade
from tests.blind.draw.separated_sets import Separation, partners_of, statements_of
from tests.blind.draw.table_against_the_true_law import table

Line = Mapping[str, Any]


def compared(line: Line, seed: int, partners: Mapping[str, frozenset[str]]) -> dict[str, Any]:
    """All that is measured of one case, for JSON.

    Parameters
    ----------
    line : mapping
        Of the runner.
    seed : int
        Of the draw.
    partners : mapping of str to frozenset of str
        Laws that stood in a set with one, by law.
    """
    judged, began = judge(line), time.monotonic()
    case = remade(line["answer"], seed)
    fixed = _fixed(judged, line["answer"])
    free = coordinates(case.plant, _laws(judged), _free(case, fixed))
    law = TrueLaw(case, free)
    found: dict[str, Any] = {
        "case": judged.case,
        "stratum": judged.stratum,
        "machine": judged.machine,
        "hidden": list(judged.hidden),
        "outcome": judged.outcome,
        "held_out": None,
        "statements": [],
        "intervals": [],
    }
    if judged.stratum == "owed" and judged.is_owed:
        found["held_out"] = held_out(line, law)
    if judged.stratum in ("owed", "pair") and judged.is_owed:
        separation = Separation(case, line["answer"])
        found["statements"] = [
            {
                "law": one.law,
                "told": sorted(one.told),
                "gains": {
                    rival: _rounded(separation.gain(one.law, rival)) for rival in sorted(one.rivals)
                },
            }
            for one in statements_of(judged, partners)
        ]
    if judged.intervals:
        found["intervals"] = widths(judged, law, fixed)
    return {**found, "seconds": round(time.monotonic() - began, 1)}


def held_out(line: Line, law: TrueLaw) -> dict[str, Any]:
    """Errors of what was told, and of the true law fitted to the same recordings.

    Parameters
    ----------
    line : mapping
        Of the runner.
    law : TrueLaw
        The plant.
    """
    if line["diagnosis"] is None:
        return {"why": "no diagnosis"}
    fit = line["diagnosis"]["fit"]
    fitted_on, held = ([_number(name) for name in fit[key]] for key in ("fitted_on", "held_out"))
    told = told_errors(line["diagnosis"], law.case.machine.is_open_loop)
    if not held or set(held) & set(fitted_on):
        return {"why": "no whole recording was held out"}
    if not told:
        return {"why": "no run of an open loop that nothing corrects"}
    named = any(errors["augmented"] is not None for errors in fit["signals"].values())
    if not named and claims_of(line["diagnosis"]):
        return {"why": "told as a fixed parameter, with which no error is stated"}
    recorded = law.case.recordings()
    noise = {name: errors["noise_floor"] for name, errors in fit["signals"].items()}
    own = [recorded[k] for k in fitted_on]
    x = law.fitted(own, fitted_on, _scales(law, own, noise))
    true = errors_of(law, recorded, x, held)
    return {
        "ratio": _rounded(joint_ratio(told, true, noise)),
        "told": {name: _rounded(value) for name, value in told.items()},
        "true": {name: _rounded(value) for name, value in true.items()},
        "noise": {name: _rounded(value) for name, value in noise.items()},
        "named": named,
        "moved": [_rounded(step) for step in x],
    }


def _scales(law: TrueLaw, recorded: Columns, noise: Mapping[str, float]) -> list[float]:
    """Noise of each compared column as it was told, in the column's unit."""
    names = ["position", law.case.machine.command_name]
    shown = names[:1] if law.case.machine.is_open_loop else names
    return [
        noise[name] * float(np.ptp(np.concatenate([one[:, k] for one in recorded])))
        for k, name in enumerate(shown)
    ]


def widths(judged: Judged, law: TrueLaw, fixed: str) -> list[dict[str, Any]]:
    """Told and narrowest widths of all intervals that are judged.

    Parameters
    ----------
    judged : Judged
        The case.
    law : TrueLaw
        The plant.
    fixed : str
        Plant parameter that the twin holds fixed at a wrong value; empty without one.
    """
    fmu_names = {fmu: own for own, fmu in law.case.machine.uncertain.items()}
    if fixed:
        fmu_names[judged.hidden[-1].split(":", 1)[1]] = fixed
    names = [interval.name for interval in judged.intervals]
    bounds = narrowest(law, names, fmu_names)
    laws = tuple(f"{name}." for name in judged.hidden)
    return [
        {
            "name": one.name,
            "kind": "law" if one.name.startswith(laws) else "parameter",
            "width": _rounded(one.high - one.low),
            "narrowest": _rounded(bounds[one.name].width),
            "narrowest_without": _rounded(bounds[one.name].width_without),
            "by_frequency": _rounded(bounds[one.name].width_by_frequency),
            "holds": one.holds,
        }
        for one in judged.intervals
    ]


def _laws(judged: Judged) -> tuple[str, ...]:
    return () if judged.stratum in ("null", "decoy") else judged.hidden


def _free(case: Remade, fixed: str) -> list[str]:
    return [*case.machine.free, *([fixed] if fixed and fixed not in case.machine.free else [])]


def _fixed(judged: Judged, answer: Mapping[str, Any]) -> str:
    """Plant parameter of a null whose twin holds it fixed at a wrong value."""
    if not answer["details"].get("fixed"):
        return ""
    return VARIANTS[judged.family][judged.variant].parameter


def _rounded(value: float) -> float | None:
    """Five digits, as JSON holds them; None for what has no end."""
    return float(f"{value:.5g}") if math.isfinite(value) else None


def _number(name: str) -> int:
    return int(name.removeprefix("rec").removesuffix(".csv"))


UNKNOWN_NOISE = frozenset({"logger", "timing", "loop"})
"""Kinds of nulls whose noise is not of the encoder and of the command's column alone: the bound of
their intervals is not counted."""


def is_compared(judged: Judged) -> bool:
    """Whether any of the three measures has something to say of a case."""
    if judged.stratum == "outside" or judged.family in UNKNOWN_NOISE:
        return False
    is_told = judged.is_owed and judged.stratum in ("owed", "pair")
    return bool(judged.intervals) or is_told


def run(outcomes: Sequence[Line], seed: int, to: Path, only: Sequence[str] | None) -> None:
    """Write what is missing of the lines, in the order of the outcomes.

    Parameters
    ----------
    outcomes : sequence of mapping
        Lines of the runner.
    seed : int
        Of their draw.
    to : Path
        File of lines; those that are there stay.
    only : sequence of str, optional
        Cases.
    """
    drop_cut_line(to)
    done = {one["case"] for one in read_outcomes(to)}
    judged = [judge(line) for line in outcomes]
    partners = partners_of(judged)
    wanted = [
        line
        for line, one in zip(outcomes, judged, strict=True)
        if is_compared(one) and one.case not in done and (only is None or one.case in only)
    ]
    for k, line in enumerate(wanted, 1):
        found = compared(line, seed, partners)
        with to.open("a", encoding="utf-8") as file:
            file.write(json.dumps(found) + "\n")
        print(f"{k} of {len(wanted)}: case {found['case']}, {found['seconds']} s", flush=True)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.draw.against_the_true_law."""
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").strip(), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("outcomes", type=Path)
    parser.add_argument("--seed", type=int, required=True, help="of the registered draw")
    parser.add_argument("--to", type=Path, required=True, help="file of lines, one a case")
    parser.add_argument("--plant", type=Path, help="truth.c as it was when the draw was made")
    parser.add_argument("--only", nargs="+", metavar="CASE")
    parser.add_argument("--text", type=Path, help="file for the table")
    given = parser.parse_args(arguments)
    if given.plant is not None:
        truth.SOURCE = given.plant
    outcomes = read_outcomes(given.outcomes)
    run(outcomes, given.seed, given.to, given.only)
    typed = " ".join(sys.argv[1:] if arguments is None else arguments)
    command = f"python -m tests.blind.draw.against_the_true_law {typed}"
    tell(f"{command}\n\n{table(read_outcomes(given.to), outcomes)}", given.text)


if __name__ == "__main__":
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    main()
