"""Writes trials and events until it is killed; says what the store has acknowledged.

Usage: killed_writer.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import example_trial


def main(folder: Path) -> None:
    """Write as fast as the disk allows."""
    with StudyStore.open_for_writing(folder) as store:
        number = store.next_number()
        while True:
            store.log("ask", number=number)
            print(f"asked {number}", flush=True)
            store.write_trial(example_trial(number))
            print(f"stored {number}", flush=True)
            number += 1


if __name__ == "__main__":
    main(Path(sys.argv[1]))
