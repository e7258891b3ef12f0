"""How large is the decision: its lines, its table of numbers, and numbers outside of it.

    python -m tests.benchmarks.decision_size \\
        > tests/benchmarks/results/decision_size/decision_size.txt

A number is a literal in a statement of a module, such as `_TRIED = 16`; of a table each entry
counts. Docstrings and blank lines are lines.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import gmfbo.diagnosis

FOLDER = Path(gmfbo.diagnosis.__file__).parent
TABLE = FOLDER / "comparison" / "numbers.py"
DECISION = (
    "comparison",
    "naming",
    "outside",
    "validating",
    "screening",
    "steps.py",
    "conclusion.py",
)
"""What decides, from opened recordings to a verdict; of these all files count."""


def files_of(part: str) -> list[Path]:
    """Modules of a part of the diagnosis."""
    path = FOLDER / part
    return [path] if path.is_file() else sorted(path.rglob("*.py"))


def numbers_in(path: Path) -> list[float]:
    """Numeric literals in the statements of a module, outside of its functions and classes."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found: list[float] = []
    for statement in tree.body:
        if isinstance(statement, (ast.Assign, ast.AnnAssign)):
            found += _literals(statement)
    return found


def _literals(statement: ast.stmt) -> Iterator[float]:
    for node in ast.walk(statement):
        value = node.value if isinstance(node, ast.Constant) else None
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            yield value


def table() -> str:
    """A line a part: lines, and numbers outside of the table."""
    rows = [f"{'part':<16}{'lines':>7}{'numbers':>9}"]
    lines, numbers = 0, 0
    for part in DECISION:
        files = files_of(part)
        own = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files)
        few = sum(len(numbers_in(path)) for path in files if path != TABLE)
        rows.append(f"{part:<16}{own:>7}{few:>9}")
        lines, numbers = lines + own, numbers + few
    rows.append(f"{'all':<16}{lines:>7}{numbers:>9}")
    everywhere = sum(len(numbers_in(path)) for path in FOLDER.rglob("*.py") if path != TABLE)
    rows.append(f"the table: {len(numbers_in(TABLE))} numbers; all of the diagnosis: {everywhere}")
    return "\n".join(rows)


def main() -> int:
    """Print the table."""
    print(table())
    return 0


if __name__ == "__main__":
    sys.exit(main())
