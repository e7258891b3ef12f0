"""Pages of notebooks hold the code that was run, and the text that the notebooks have now."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.notebooks import pages

PAGES = sorted(path.stem for path in pages.PAGES.glob("*.md"))


def test_most_notebooks_have_a_page() -> None:
    assert set(PAGES) <= set(pages.names())
    assert "01_a_first_tuning" in PAGES


@pytest.mark.parametrize("name", PAGES)
def test_a_page_shows_the_code_that_was_run_and_the_text_of_now(name: str) -> None:
    text = (pages.PAGES / f"{name}.md").read_text(encoding="utf-8")
    assert text == pages.rewrite(name), f"run {pages.COMMAND} --text {name.partition('_')[0]}"
    ran, shown = pages.kept(text)
    assert "at commit" in ran
    assert any(one.output for one in shown)
    drawn = {path.name for path in pages.PAGES.glob(f"{name}-*.svg")}
    assert all(f"({file})" in text for file in drawn)
    assert text.count(".svg)") == len(drawn)
    assert "/tmp/" not in text
    printed = [line for one in shown for line in one.output.splitlines()]
    assert all(pages.wrapped(line) == line for line in printed), "a sentence leaves the page"


def test_control_other_code_than_that_which_was_run_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "01_a_first_tuning"
    other = pages.NOTEBOOKS / f"{name}.py"
    changed = other.read_text(encoding="utf-8").replace("is1_runs = 5\n", "is1_runs = 7\n", 1)
    (tmp_path / f"{name}.py").write_text(changed, encoding="utf-8")
    monkeypatch.setattr(pages, "NOTEBOOKS", tmp_path)
    with pytest.raises(ValueError, match="its code has changed since it was run"):
        pages.rewrite(name)


def test_a_page_is_written_of_text_code_prints_and_drawings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = """# %% [markdown]
# # A title
#
# See [another](02_other.py), [words](docs/words.md#here) and [a site](https://example.com/x).

# %%
print("six", 6)

# %% [markdown]
# The end.

# %%
silent = 1
"""
    (tmp_path / "01_some.py").write_text(source, encoding="utf-8")
    monkeypatch.setattr(pages, "NOTEBOOKS", tmp_path)
    monkeypatch.setattr(pages, "PAGES", tmp_path)
    shutil.copy(tmp_path / "01_some.py", tmp_path / "02_other.md")
    text = pages.page("01_some", "Its outputs are of today.", ["```text\nsix 6\n```\n", ""])
    assert text.startswith("# A title\n\nSee [another](02_other.md), [words](../words.md#here)")
    assert "[a site](https://example.com/x)" in text
    ran, shown = pages.kept(text)
    assert ran == "Its outputs are of today."
    assert [one.output for one in shown] == ["```text\nsix 6\n```\n", ""]
    (tmp_path / "01_some.md").write_text(text, encoding="utf-8")
    assert pages.rewrite("01_some") == text
