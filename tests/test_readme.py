"""README's promises that a test can hold it to."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from PIL import Image

from tests.examples.screenshot import IMAGES, SCHEMES
from tests.readme_blocks import README, ROOT, Typed, difference, type_in, typed_blocks

MOST_WORDS = 1350
MOST_WORDS_OF_A_SENTENCE = 30
BLOCKS = typed_blocks(README)
SHELL = [block for block in BLOCKS if "pip install" not in block.commands]
(DEMO,) = (block for block in BLOCKS if "gmfbo demo" in block.commands)


def test_constraints_hold_an_exact_version_of_every_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = [*project["dependencies"], *project["optional-dependencies"]["tests"]]
    pinned = {
        line.partition("==")[0].lower().replace("_", "-")
        for line in (ROOT / "tests/constraints.txt").read_text().splitlines()
        if "==" in line
    }
    names = {re.split(r"[<>=;\s\[]", text)[0].lower() for text in wanted}
    assert names <= pinned, names - pinned


def test_torch_is_pinned_to_the_tested_build_that_readme_names() -> None:
    pins = (ROOT / "tests/constraints.txt").read_text()
    (version,) = re.findall(r"^torch==(\S+)", pins, re.MULTILINE)
    assert version == "2.13.0"
    before, _, _ = README.partition("<!-- demo command -->")
    assert f"locally/) {version}\ninto it first" in before


def test_readme_marks_one_demo_and_one_test_command() -> None:
    for mark in ("demo", "test"):
        block = re.search(rf"<!-- {mark} command -->\n```\n(.+)\n```\n<!-- end -->", README)
        assert block is not None
        assert "-c tests/constraints.txt" in block.group(1)


def test_readme_does_not_hide_what_pip_downloads() -> None:
    lines = [line for block in BLOCKS for line in block.commands.splitlines() if "pip" in line]
    assert len(lines) == 2
    assert not any(re.search(r"pip install .*-q", line) for line in lines)


def test_readme_can_be_read_in_minutes() -> None:
    assert len(README.split()) <= MOST_WORDS  # as `wc -w` counts


def test_the_real_axis_is_told_with_its_halves_and_beside_the_published_model() -> None:
    measured = ROOT / "tests/benchmarks/results/emps_diagnosis/emps_diagnosis.txt"
    errors = re.findall(
        r"^force error: ([\d.]+)% with parameters alone, ([\d.]+)% with physics",
        measured.read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    ((before, after),) = errors
    ((told_before, told_after, line),) = re.findall(
        r"^- \*\*(\S+) % to (\S+) %\*\*(: error of the simulated voltage.*?)(?=^- )",
        README,
        re.MULTILINE | re.DOTALL,
    )
    assert float(told_before) == pytest.approx(float(before), abs=0.5)
    assert float(told_after) == pytest.approx(float(after), abs=0.05)
    for part in (
        "second half",
        "found in the first",
        "cut by hand",
        "3.8 % with 4 numbers",
        "has 10",
    ):
        assert part in line
    notebook = (ROOT / "notebooks/03_find_the_missing_physics.py").read_text(encoding="utf-8")
    told = " ".join(notebook.replace("\n# ", " ").split())
    assert "with eight numbers beside mass and viscous friction" in told
    assert "leave 3.8 % with four numbers" in told


def sentences(text: str) -> list[str]:
    """Sentences of prose, lists and cells, without code blocks, tags and targets of links."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"<[^>]*>", "", text, flags=re.DOTALL)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    paragraphs = re.split(r"\n\n|\n- |\n#|\|", text)
    return [
        sentence
        for paragraph in paragraphs
        for sentence in re.split(r"(?<=[.!?:])\s+|·|;", paragraph)
        if sentence.strip()
    ]


def test_no_sentence_of_readme_is_long() -> None:
    long = [one for one in sentences(README) if len(one.split()) > MOST_WORDS_OF_A_SENTENCE]
    assert not long


EXPLAINED = {
    "FMUs?": "exported as an FMU",
    "twins?": "**A digital twin**",
    "twin file": "The [**twin file**]",
    "noise floor": "The **noise floor**",
    "effects?": "An **effect**",
    "ports?": "A **port**",
    "stud(?:y|ies)": "A **study**",
}
"""What a reader may not know, and where README begins to explain it."""


def early_uses(text: str) -> list[str]:
    """Terms that prose uses before it explains them."""
    prose = " ".join(sentences(text))
    prose = re.sub(r"`[^`]*`", "", re.sub(r"\s+", " ", prose))
    found = []
    for term, explained in EXPLAINED.items():
        used = re.search(rf"\b{term}\b", prose)
        assert used is not None, term
        place = prose.find(explained)
        if place < 0 or used.start() < place:
            found.append(term)
    return found


def test_readme_explains_a_term_before_it_uses_it() -> None:
    assert not early_uses(README)


def test_control_a_term_that_is_used_too_early_is_noticed() -> None:
    first = README.replace("gmfbo compares a simulated", "A port. gmfbo compares a simulated", 1)
    assert early_uses(first) == ["ports?"]


def test_every_file_that_readme_links_to_is_there() -> None:
    targets = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)|(?:src|srcset)=\"([^\"]+)\"", README)
    named = [one or other for one, other in targets]
    assert len(named) > 20
    assert [name for name in named if not (ROOT / name).exists()] == []


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_picture_shows_the_numbers_that_stand_below_it(scheme: str) -> None:
    with Image.open(IMAGES / f"report-{scheme}.png") as picture:
        headline = picture.info["Description"]
    (errors,) = re.findall(r"^- \*\*(.+?)\*\*: error of the torque", README, re.MULTILINE)
    assert f"falls from {errors} (" in headline


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """What each block printed, typed in order into one shell that starts in a clone."""
    return type_in(SHELL, tmp_path_factory.mktemp("clone"))


@pytest.mark.parametrize("number", range(len(SHELL)))
def test_a_block_typed_in_order_prints_what_readme_says(number: int, printed: list[str]) -> None:
    assert not difference(SHELL[number].printed, printed[number])


def test_readme_says_what_every_block_but_that_of_the_examples_prints() -> None:
    silent = [block.commands for block in SHELL if not block.printed]
    assert len(SHELL) == 4
    assert ["gmfbo examples" in commands for commands in silent] == [True]


@pytest.mark.slow
def test_the_demo_prints_what_readme_says(tmp_path: Path) -> None:
    _, _, demo = DEMO.commands.rpartition(" && ")
    (printed,) = type_in([Typed(demo, DEMO.printed)], tmp_path)
    assert not difference(DEMO.printed, printed)
    assert (tmp_path / "gmfbo-demo/found/report.html").is_file()


SAID = "error 6.7 % falls to 0.43 %\n...\nlevel = 0.2 [0.199, 0.201] N m\n"


def test_numbers_agree_within_the_digits_that_readme_gives() -> None:
    printed = "error  6.68 % falls to 0.426 %\n\nmore\nlevel = 0.21 [0.1992, 0.2008] N m\n"
    assert not difference(SAID, printed)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("6.7", "6.9"),  # two units of the last digit
        ("0.43", "0.4"),
        ("level", "width"),
        ("N m", "N"),
        ("level", "also\nlevel"),  # a line that README has without a gap before it
        ("error 6.7 % falls to 0.43 %\n", ""),
    ],
)
def test_control_another_number_word_or_line_is_noticed(old: str, new: str) -> None:
    printed = SAID.replace("...\n", "") if "also" in new else SAID
    said = SAID.replace("...\n", "") if "also" in new else SAID
    assert difference(said, printed.replace(old, new, 1))
