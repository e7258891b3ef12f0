"""Tables and figures in the documents are those of the results."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.benchmarks.plants import safety, twin_kinds
from tests.benchmarks.plants.arrival import read_lines
from tests.benchmarks.plants.run import RESULTS as PLANT_RESULTS
from tests.benchmarks.tables import diagnosis, plant_rivals, plant_variants, plants
from tests.benchmarks.tables.results import MADE, RESULTS, commands
from tests.benchmarks.tables.written import README, ROOT, TABLES, documented, write

FRONT = (ROOT / README).read_text(encoding="utf-8")
PROSE = re.sub(r"\s+", " ", FRONT)  # whatever its lines


@pytest.mark.parametrize(("document", "table"), TABLES)
def test_a_table_is_that_of_the_results(document: str, table: Callable[[], str]) -> None:
    held = documented((ROOT / document).read_text(encoding="utf-8"), table())
    assert held == table(), "run python -m tests.benchmarks.tables"


def test_control_a_table_that_differs_by_a_digit_is_written_anew(tmp_path: Path) -> None:
    for name in {name for name, _ in TABLES}:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    row = diagnosis.for_readme().splitlines()[2]
    assert FRONT.count(row) == 1
    front = tmp_path / README
    front.write_text(FRONT.replace(row, row.replace(" of ", " in ")), encoding="utf-8")
    assert write(tmp_path) == [README]
    assert front.read_text(encoding="utf-8") == FRONT
    front.write_text(FRONT.replace("| what | result |", "| what | came |"), encoding="utf-8")
    with pytest.raises(ValueError, match="expected one table that begins with"):
        write(tmp_path)


def test_figures_in_the_text_of_readme_are_those_of_the_results() -> None:
    all_plants = plants.told()
    fitted = "identify_then_optimise"
    ours, known, theirs = (all_plants.means[name] for name in (plants.OURS, fitted, "bo_ei"))
    assert f"**{ours:.1f}, not {known:.1f} or {theirs:.1f}**" in PROSE
    assert f"fitted to the runs needs {known:.1f}, no model {theirs:.1f}." in PROSE
    assert f"{all_plants.seeds} studies of each axis" in PROSE
    assert f"of {len(diagnosis.judged())} simulated axes" in PROSE
    never = [100.0 * all_plants.never[name] for name in plants.METHODS]
    others = sorted(never[1:])
    assert f"Of the tunings {never[0]:.0f} % never arrived" in PROSE
    assert f"of other methods' {others[0]:.0f} to {others[-1]:.0f} %" in PROSE
    assert f"of {MADE['draw']['engine']}, {MADE['draw']['committed'][-11:-1]}:" in PROSE
    axis = (RESULTS / "emps_diagnosis/emps_diagnosis.txt").read_text("utf-8")
    said = re.search(r"^force error: ([\d.]+)% with .*, ([\d.]+)% with", axis, re.MULTILINE)
    assert said is not None
    before, after = map(float, said.groups())
    assert f"**{before:.0f} % to {after:.1f} %**" in PROSE


def test_figures_of_the_plants_are_those_of_the_results() -> None:
    page = (ROOT / "notebooks/docs/tuning_benchmark.md").read_text(encoding="utf-8")
    text, made = re.sub(r"\s+", " ", page), MADE["plants"]
    ratio, low, high = plants.told().ratio
    assert f"needs {ratio:.2f} [{low:.2f}, {high:.2f}] of the runs of the better" in text
    less, most, least = (-100.0 * value for value in plants.told().never_less)
    assert f"{less:.0f} [{least:.0f}, {most:.0f}] points less often" in text
    assert made["command"] in text
    assert f"Engine of {made['engine']}, committed with {made['committed']}" in text
    lines = [line for line in read_lines(PLANT_RESULTS) if line["method"] in plants.METHODS]
    assert {line["commit"][:8] for line in lines} == {made["engine"]}
    assert f"{len(lines)} studies" in text


def test_what_the_correction_of_trajectories_is_worth_is_that_of_the_results() -> None:
    page = (ROOT / "notebooks/docs/tuning_benchmark.md").read_text(encoding="utf-8")
    text = re.sub(r"\s+", " ", page)
    ours, without, third, calibrated = (
        plant_rivals.mean_of(name)
        for name in (plants.OURS, "is3_none", "is3_source", "gmfbo_calibrated")
    )
    assert f"needs {without:.1f} runs in place of {ours:.1f}, and {third:.1f} with" in text
    assert f"its twin, and needs {calibrated:.1f}." in text
    spent = plant_rivals.costs_to_target("gmfbo_paper")
    *first, last = (f"{spent[plant]:.0f}" for plant in twin_kinds.CHOSEN)
    assert f"`gmfbo_paper` spends {', '.join(first)} and {last} until" in text


def test_figures_of_cheap_rivals_kinds_of_twins_and_envelopes_are_those_of_the_results() -> None:
    page = (ROOT / "notebooks/docs/tuning_benchmark.md").read_text(encoding="utf-8")
    text = re.sub(r"\s+", " ", page)
    cheap = [one for one in read_lines(PLANT_RESULTS) if one["method"] in plant_variants.CHEAP]
    kinds = [one for kind in twin_kinds.KINDS for one in read_lines(twin_kinds.FOLDER / kind)]
    guarded = read_lines(safety.FOLDER)
    for lines in (kinds, guarded, cheap):
        (engine,) = {line["commit"][:8] for line in lines}
        assert engine in text
    far, peer = twin_kinds.runs_of("far_off")["linear_axis"]
    assert f"costs {(far - peer).mean():.1f} runs on `linear_axis`" in text
    gone, count = safety.left(guarded, plants.OURS, safety.LIMITED)
    assert gone == 0
    assert f"None of {count} runs" in text
    assert f"(at most {100.0 * (1.0 - 0.05 ** (1.0 / count)):.1f} %, one-sided, 95 %" in text


def test_figures_of_robustness_are_those_of_its_table() -> None:
    page = (ROOT / "notebooks/docs/tuning_benchmark.md").read_text(encoding="utf-8")
    table = (PLANT_RESULTS / "robustness.txt").read_text(encoding="utf-8")
    rows = re.findall(
        r"^mean +(\w+) +(\d+) % +(\S+) +(\S+) +(\d+) % +(\d+) %$", table, re.MULTILINE
    )
    assert {row[0] for row in rows} == set(plants.METHODS)
    for method, settle, mean, worst, half, twice in rows:
        assert f"| `{method}` | {settle} % | {mean} | {worst} | {half} %, {twice} % |" in page


def test_every_result_that_is_told_says_command_commit_and_date() -> None:
    dated = re.compile(r"[0-9a-f]{7}.* \(\d{4}-\d\d-\d\d\)$")
    for study, committed in MADE["tuning"].items():
        assert dated.match(committed), study
        assert all(one.startswith("gmfbo compare ") for one in commands(study)), study
    assert dated.match(MADE["draw"]["committed"])
    beside = (RESULTS / "diagnosis_draw/README.md").read_text(encoding="utf-8")
    assert MADE["draw"]["engine"] in beside
    for file in MADE["draw"]["files"].values():
        assert Path(file).name in beside
