"""What a benchmark's diagnoses said, as one text with a line a case.

    python -m tests.blind.outcomes keep FILE --out FOLDER
    python -m tests.blind.outcomes take FILE --out FOLDER

A run takes hours: its text goes on elsewhere with the cases that are missing, and is scored again
by other rules within a minute. `take` wants the cases generated, by the same seed, and leaves
alone what has an outcome there already.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tests.blind.baselines import baseline_path
from tests.blind.generate import check_hashes
from tests.blind.run import outcome_path

SCORED = ("verdict", "effects", "parameters", "location", "fit", "cost")
"""Of diagnosis.json, what a score is made of."""

OF_AN_EFFECT = ("name", "probability", "parameters", "indistinguishable_from")
"""Of each of its effects."""


def keep(out: Path, file: Path) -> int:
    """Write what was said of each case that has an outcome; their number.

    Parameters
    ----------
    out : Path
        Folder of the benchmark.
    file : Path
        To write.

    Raises
    ------
    ValueError
        An answer is not the one that was hashed.
    """
    lines = [json.dumps({"benchmark": _read(out / "benchmark.json")})]
    for case in check_hashes(out):
        ended = outcome_path(out, case)
        if not ended.exists():
            continue
        line: dict[str, Any] = {"case": case, "outcome": _read(ended)}
        diagnosis = ended.with_name("diagnosis.json")
        if diagnosis.exists():
            line["diagnosis"] = _scored(_read(diagnosis))
        if baseline_path(out, case).exists():
            line["baselines"] = _read(baseline_path(out, case))
        lines.append(json.dumps(line))
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return len(lines) - 1


def take(out: Path, file: Path) -> int:
    """Put kept outcomes where their cases have none; how many.

    Parameters
    ----------
    out : Path
        Folder of the same benchmark, generated.
    file : Path
        That `keep` wrote.

    Raises
    ------
    ValueError
        It is of another benchmark, or an answer is not the one that was hashed.
    """
    head, *lines = map(json.loads, file.read_text(encoding="utf-8").splitlines())
    here = _read(out / "benchmark.json")
    if head["benchmark"] != here:
        raise ValueError(f"{file.name} is of benchmark {head['benchmark']}, not of {here}")
    known = set(check_hashes(out))
    taken = 0
    for line in lines:
        case = line["case"]
        ended = outcome_path(out, case)
        if case not in known or ended.exists():
            continue
        ended.parent.mkdir(parents=True, exist_ok=True)
        if "diagnosis" in line:
            _write(ended.with_name("diagnosis.json"), line["diagnosis"])
        if "baselines" in line:
            _write(baseline_path(out, case), line["baselines"])
        _write(ended, line["outcome"])  # last: it says that the case is done
        taken += 1
    return taken


def _scored(diagnosis: Mapping[str, Any]) -> dict[str, Any]:
    effects = [{k: e[k] for k in OF_AN_EFFECT if k in e} for e in diagnosis.get("effects", [])]
    return {k: diagnosis[k] for k in SCORED if k in diagnosis} | {"effects": effects}


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _write(path: Path, content: Any) -> None:
    path.write_text(json.dumps(content), encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.outcomes."""
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").strip(), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("keep", "take"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--out", type=Path, required=True, help="folder of the benchmark")
    given = parser.parse_args(arguments)
    count = (keep if given.what == "keep" else take)(given.out, given.file)
    print(f"{count} outcomes {'kept' if given.what == 'keep' else 'taken'}")


if __name__ == "__main__":
    main()
