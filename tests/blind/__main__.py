"""Generate, run and score a benchmark; whatever is there already is kept."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from tests.blind.baseline_table import baseline_table
from tests.blind.generate import CASES, generate
from tests.blind.run import TIME_LIMIT, run_all
from tests.blind.score import read_scores
from tests.blind.tables import report

RESULTS = Path(__file__).resolve().parents[1] / "benchmarks" / "results"


def main() -> None:
    """Command line: python -m tests.blind."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").strip())
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", nargs="+", default=[], metavar="CASE")
    parser.add_argument("--limit", type=float, default=TIME_LIMIT, help="[s] for each case")
    parser.add_argument("--text", type=Path, help="report; by default in the folder of its seed")
    given = parser.parse_args()
    generate(given.cases, given.seed, given.out, given.jobs)
    run_all(given.out, given.jobs, given.only, given.limit)
    benchmark = json.loads((given.out / "benchmark.json").read_text(encoding="utf-8"))
    scores = read_scores(given.out)
    text = report(scores, benchmark, [baseline_table(given.out, scores)])
    study = RESULTS / f"blind_seed_{given.seed}"
    file = given.text or study / f"blind_{given.cases}_seed_{given.seed}.txt"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
