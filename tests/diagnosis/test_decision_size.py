"""Numbers that decide stand in one table, and what stands elsewhere is counted and published."""

from __future__ import annotations

from pathlib import Path

from tests.benchmarks.decision_size import TABLE, numbers_in, table

PUBLISHED = (
    Path(__file__).parents[1] / "benchmarks" / "results" / "decision_size" / "decision_size.txt"
)


def test_the_published_count_is_that_of_the_code() -> None:
    """Lines may come and go; a number that is added outside of the table is seen here."""

    def numbers(text: str) -> list[str]:
        return [line.split()[-1] for line in text.splitlines()[1:]]

    assert numbers(table()) == numbers(PUBLISHED.read_text(encoding="utf-8"))


def test_a_number_of_a_tuple_or_a_table_counts_and_one_in_a_docstring_does_not(
    tmp_path: Path,
) -> None:
    made = tmp_path / "made.py"
    made.write_text('"""At 5."""\nA, B = 1, -2.5\nC = {"x": 3}\nD: int = 4\n"""[s] 6"""\n')
    assert numbers_in(made) == [1, 2.5, 3, 4]
    assert len(numbers_in(TABLE)) > 0
