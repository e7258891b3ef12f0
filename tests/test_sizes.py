"""Files, functions and folders of the package stay small enough to be read at a glance."""

from __future__ import annotations

import ast
from collections import Counter
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "gmfbo"
MOST_LINES_OF_A_FILE, MOST_LINES_OF_A_FUNCTION, MOST_FILES_OF_A_FOLDER = 400, 60, 25
ONE_FILE_A_LAW = "physics/effects"
"""Folder that grows with the library, and holds nothing else."""


def texts(package: Path) -> dict[str, str]:
    return {
        path.relative_to(package).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(package.rglob("*.py"))
    }


def long_files(package: Path) -> list[str]:
    lengths = {name: len(text.splitlines()) for name, text in texts(package).items()}
    return [f"{name}: {n}" for name, n in lengths.items() if n > MOST_LINES_OF_A_FILE]


def long_functions(package: Path) -> list[str]:
    """Signature, docstring and body are counted together, decorators are not."""
    found = []
    for name, text in texts(package).items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                assert node.end_lineno is not None
                lines = node.end_lineno - node.lineno + 1
                if lines > MOST_LINES_OF_A_FUNCTION:
                    found.append(f"{name} {node.name}: {lines}")
    return found


def crowded_folders(package: Path) -> list[str]:
    counts = Counter(Path(name).parent.as_posix() for name in texts(package))
    counts.pop(ONE_FILE_A_LAW, None)
    return [f"{folder}: {n}" for folder, n in counts.items() if n > MOST_FILES_OF_A_FOLDER]


def test_no_file_is_long() -> None:
    assert not long_files(PACKAGE)


def test_no_function_is_long() -> None:
    assert not long_functions(PACKAGE)


def test_no_folder_is_crowded() -> None:
    assert not crowded_folders(PACKAGE)


def test_control_what_is_too_large_by_one_is_found(tmp_path: Path) -> None:
    folder = tmp_path / "room"
    folder.mkdir()
    for number in range(MOST_FILES_OF_A_FOLDER + 1):
        (folder / f"file{number:02}.py").write_text("")
    (folder / "file00.py").write_text("x = 0\n" * (MOST_LINES_OF_A_FILE + 1))
    body = "    x = 0\n" * MOST_LINES_OF_A_FUNCTION
    (folder / "file01.py").write_text(
        f"class Held:\n    def long(self):\n{body.replace('    ', '        ')}"
    )
    assert long_files(tmp_path) == ["room/file00.py: 401"]
    assert long_functions(tmp_path) == ["room/file01.py long: 61"]
    assert crowded_folders(tmp_path) == ["room: 26"]
