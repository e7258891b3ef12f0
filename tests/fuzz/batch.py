"""One batch of hostile files, for `tests/benchmarks/fuzz_readers.py`.

Usage: python -m tests.fuzz.batch TARGET BATCH SEED COUNT KEEP
"""

from __future__ import annotations

import hashlib
import json
import random
import resource
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from tests.fuzz.targets import TARGETS
from tests.fuzz.trying import Tally, try_file

_ADDRESS_SPACE = 6 * 2**30


def main() -> None:
    """Try the files of one batch; the last line on standard output is the tally."""
    name, batch, campaign, count, keep = sys.argv[1:]
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (_ADDRESS_SPACE, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    target, tally = TARGETS[name], Tally()
    random.seed(0)
    Path(keep).mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:

        @seed(f"{campaign} {name} {batch}")
        @settings(
            max_examples=int(count),
            deadline=None,
            database=None,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        @given(data=st.data())
        def tried(data: st.DataObject) -> None:
            content = data.draw(target.files())
            if tally.tried < int(count):
                tried_last = Path(keep) / f"last.{batch}.{target.name}"
                tried_last.write_bytes(content)  # what is left of it if this process crashes
                faults = try_file(target, content, Path(folder), tally)
                tried_last.unlink()
                if faults:
                    _keep(content, faults, Path(keep), target.name)

        tried()
    print()
    print(json.dumps(asdict(tally)))


def _keep(content: bytes, faults: list[str], folder: Path, name: str) -> None:
    """Keep a file that is a fault, with what was wrong."""
    stem = hashlib.sha256(content).hexdigest()[:12]
    (folder / f"{stem}.{name}").write_bytes(content)
    (folder / f"{stem}.txt").write_text("\n".join([*faults, ""]), encoding="utf-8")


if __name__ == "__main__":
    main()
