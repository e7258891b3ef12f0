"""The page of a study: every number on it is that of the store, read by plain h5py."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from gmfbo.errors import StoreError
from gmfbo.recordings.store.pack import pack_study
from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.study_remarks import study_remarks
from tests.pages.page_text import PageText, at_path, rounds_to
from tests.reports.study.example_studies import ExampleStudy, write_example_study


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_example_study(tmp_path_factory.mktemp("studies"))


@pytest.fixture(scope="module")
def read(folder: Path) -> PageText:
    return PageText(study_page(StudyReview.read(folder)))


@pytest.fixture(scope="module")
def content(read: PageText) -> Any:
    return json.loads(read.embedded["study"])


def stored(folder: Path) -> dict[int, dict[str, Any]]:
    """Attributes and datasets of each trial, as anybody without gmfbo reads them."""
    found = {}
    for path in sorted((folder / "trials").glob("*.h5")):
        with h5py.File(path, "r") as file:
            found[int(path.stem)] = {
                "attributes": dict(file.attrs),
                "columns": {name: file[name][()] for name in file},
            }
    return found


def logged(folder: Path, event: str) -> list[dict[str, Any]]:
    lines = map(json.loads, (folder / "events.jsonl").read_text().splitlines())
    return [line for line in lines if line["event"] == event]


def test_every_run_on_the_page_is_that_of_the_store(folder: Path, content: Any) -> None:
    trials, cost = stored(folder), 0.0
    assert [run["number"] for run in content["runs"]] == list(trials)
    for run in content["runs"]:
        attributes = trials[run["number"]]["attributes"]
        cost += 1.0 if attributes["source"] == "IS1" else 0.1
        assert run["cost"] == pytest.approx(cost)
        names = list(attributes["gain_names"])
        assert run["gains"] == dict(zip(names, attributes["gains"], strict=True))
        metrics = {k[7:]: v for k, v in attributes.items() if k.startswith("metric.")}
        assert run["metrics"] == metrics
        for key in ("source", "objective", "status", "started", "seconds"):
            assert run[key] == attributes[key], key
        assert run["parent"] == attributes.get("parent")
    assert content["cost"] == pytest.approx(cost)


def test_best_and_first_are_those_of_the_real_runs_that_succeeded(
    folder: Path, content: Any
) -> None:
    real = [
        (number, one["attributes"]["objective"], one["attributes"]["status"])
        for number, one in stored(folder).items()
        if one["attributes"]["source"] == "IS1"
    ]
    good = {number: objective for number, objective, status in real if status == "ok"}
    assert content["best"] == min(good, key=good.__getitem__)
    assert content["first"] == next(iter(good))
    descent = content["descent"]
    assert descent["numbers"] == [number for number, _, _ in real]
    assert descent["objective"] == [objective for _, objective, _ in real]
    so_far = [good.get(number, np.inf) for number in descent["numbers"]]
    assert descent["best"] == np.minimum.accumulate(so_far).tolist()
    trials = stored(folder)
    for name, one in content["comparison"].items():
        for which in ("first", "best"):
            held = trials[content[which]]["attributes"]
            assert one[which] == held["objective" if name == "objective" else f"metric.{name}"]


def test_mismatch_correction_and_advice_are_those_of_the_log(folder: Path, content: Any) -> None:
    asked = [event for event in logged(folder, "ask") if event["mismatch"] is not None]
    assert [(one["run"], one["mismatch"]) for one in content["mismatch"]] == [
        (event["number"], event["mismatch"]) for event in asked
    ]
    assert [one["query"] for one in content["mismatch"]] == [1, 2, 3, 4]
    assert [one["query_cost"] for one in content["mismatch"]] == [1.0, 1.0, 0.5, 0.125]
    assert [one["lengthscale"] for one in content["mismatch"]] == [1 / 1.5, 0.8, 1.0, 1.0]
    assert [(one["run"], one["twin"], one["corrected"]) for one in content["correction"]] == [
        (event["parent"], event["uncorrected_error"], event["held_out_error"])
        for event in logged(folder, "correction")
    ]
    (advice,) = logged(folder, "recommendation")
    assert content["recommendation"] == {k: advice[k] for k in ("gains", "mean", "std")}


def test_roles_tell_what_each_run_was_for(content: Any) -> None:
    told = [(run["source"], run["role"]) for run in content["runs"]]
    assert told[:8] == [("IS2", "initial")] * 8
    around = [("IS2", "beside"), ("IS3", "corrected"), ("IS3", "rejected")]
    assert told[8:16] == [("IS1", "initial"), *around] * 2
    assert told[16:20] == [("IS1", "query"), *around]
    assert told[20] == ("IS2", "query")
    assert told[21:26] == [("IS2", "renewed")] * 5
    assert content["queries"] == 4


def test_every_trajectory_is_that_of_the_store_with_its_peaks(folder: Path, read: PageText) -> None:
    told = json.loads(read.embedded["trajectories"])
    trials = stored(folder)
    assert [int(number) for number in sorted(told["runs"], key=int)] == list(trials)
    for number, one in trials.items():
        columns, run = one["columns"], told["runs"][str(number)]
        for signal, shown in run.items():
            rows = np.searchsorted(columns["time"], np.array(shown["t"]) - 1e-9)
            np.testing.assert_allclose(columns["time"][rows], shown["t"], rtol=1e-6)
            np.testing.assert_allclose(columns[signal][rows], shown["y"], rtol=5e-5)
            whole = columns[signal]
            assert max(shown["y"]) == pytest.approx(whole.max(), rel=5e-5)
            assert min(shown["y"]) == pytest.approx(whole.min(), rel=5e-5, abs=1e-12)
            if one["attributes"]["source"] == "IS3":
                before, std = columns[f"{signal}_uncorrected"], columns[f"{signal}_std"]
                np.testing.assert_allclose(before[rows], shown["u"], rtol=5e-5)
                np.testing.assert_allclose(std[rows], shown["s"], rtol=5e-5)
    real = {n for n, one in trials.items() if one["attributes"]["source"] == "IS1"}
    assert all(set(told["runs"][str(n)]) == {"position", "torque_command"} for n in real)


def test_every_marked_number_is_that_of_the_json(read: PageText, content: Any) -> None:
    assert len(read.numbers) > 200
    for number in read.numbers:
        assert rounds_to(number, at_path(content, number.path)), number


def test_every_number_of_a_run_is_in_the_table(read: PageText, content: Any) -> None:
    shown = {number.path for number in read.numbers}
    for place, run in enumerate(content["runs"]):
        path = f"runs.{place}"
        wanted = [f"{path}.{key}" for key in ("number", "query", "objective", "cost")]
        wanted += [f"{path}.metrics.{name}" for name in run["metrics"]]
        wanted += [f"{path}.gains." + name.replace(".", "\\.") for name in run["gains"]]
        assert set(wanted) <= shown, place


def test_no_table_has_a_number_without_its_place(read: PageText) -> None:
    for text in read.bare:
        assert not re.search(r"\d", re.sub(r"IS[123]", "", text)), text


def test_a_number_that_is_not_that_of_the_json_is_seen(read: PageText, content: Any) -> None:
    """Negative control: the check fails on the numbers of another study."""
    changed = json.loads(json.dumps(content))
    changed["runs"][3]["objective"] += 0.01
    wrong = [n.path for n in read.numbers if not rounds_to(n, at_path(changed, n.path))]
    assert set(wrong) == {"runs.3.objective"}


def test_a_packed_study_gives_the_same_page(folder: Path, tmp_path: Path) -> None:
    packed = pack_study(folder, tmp_path / "example.h5")
    assert study_page(StudyReview.read(packed)) == study_page(StudyReview.read(folder))


@pytest.mark.parametrize(("gains", "charts"), [(1, 1), (2, 1), (3, 3)])
def test_gains_are_a_map_of_two_and_else_a_profile_each(
    tmp_path: Path, gains: int, charts: int
) -> None:
    page = study_page(StudyReview.read(write_example_study(tmp_path, gains=gains)))
    figure = page[page.index('<figure class="gains">') : page.index('id="viewer"')]
    assert figure.count('class="area"') == charts
    assert ('class="cell' in figure) == (gains == 2)
    assert figure.count('class="mark IS1') == 5 * charts + 1  # and one in the legend
    assert figure.count('class="mark best" x="13"') == 1


def test_marks_lie_where_their_gains_are(read: PageText, content: Any, folder: Path) -> None:
    page = study_page(StudyReview.read(folder))
    figure = page[page.index('<figure class="gains">') : page.index('id="viewer"')]
    found = re.findall(
        r'class="mark IS1[^"]*" x="([\d.]+)%" y="([\d.]+)%" data-run="(\d+)"', figure
    )
    assert len(found) == 5
    (kp, kd), runs = content["gains"].values(), {run["number"]: run for run in content["runs"]}
    for x, y, number in found:
        gains = runs[int(number)]["gains"]
        share = (gains["ctl.Kp"] - kp["low"]) / (kp["high"] - kp["low"])
        assert float(x) == pytest.approx(100.0 * share, abs=0.01)
        share = (kd["high"] - gains["ctl.Kd"]) / (kd["high"] - kd["low"])
        assert float(y) == pytest.approx(100.0 * share, abs=0.01)


def test_a_new_twin_is_told_with_its_reason_escaped(
    read: PageText, content: Any, folder: Path
) -> None:
    (version,) = content["twin_versions"]
    assert version == {
        "version": "1", "reason": "friction of 0.4 N m <found> by diagnosis", "after": 17,
        "learned": ["mech.J: 0.12 -> 0.148 [0.142, 0.155] kg m2"],
    }  # fmt: skip
    assert any("<found>" in text for text in read.text)
    assert any("0.148 [0.142, 0.155]" in text for text in read.text)
    # Among the sources, and in the three charts of the trust.
    page = study_page(StudyReview.read(folder))
    assert page.count('class="new-twin"') == 4
    assert page.count("mark IS1 query early") == 4  # the map, twice the descent, the sources


def test_a_study_that_has_just_begun_has_a_page(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "new.study")
    with made.store:
        with pytest.raises(StoreError, match="expected a study with runs, but there is none yet"):
            StudyReview.read(tmp_path / "new.study")
        made.trial("IS2", made.gains())
        read = PageText(study_page(StudyReview.read(tmp_path / "new.study")))
        assert any("None of" in text for text in read.text)
        made.real(made.gains(), None, "failed")
        read = PageText(study_page(StudyReview.read(tmp_path / "new.study")))
        assert json.loads(read.embedded["study"])["descent"]["best"] == [None]


def test_runs_of_an_earlier_study_are_told_and_cost_nothing(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "later.study")
    with made.store as store:
        store.log("earlier", study="former.study", trials=[3, 7], left_out=0)
        for _ in range(8):
            made.trial("IS2", made.gains())
        for _ in range(3):
            made.trial("IS1", made.gains())
    page = study_page(StudyReview.read(tmp_path / "later.study"))
    content = json.loads(PageText(page).embedded["study"])
    assert [run["role"] for run in content["runs"][8:]] == ["earlier", "earlier", "query"]
    assert content["cost"] == pytest.approx(0.8 + 1.0)
    assert '<data data-path="earlier">2</data> real runs</b> are of an earlier study' in page


def test_a_recommendation_says_whether_it_was_run(folder: Path) -> None:
    review = StudyReview.read(folder)
    assert review.best is not None
    assert f"<span class=small>real run {review.best.number}; expected" in study_page(review)
    advice = {**(review.recommendation or {}), "gains": {"ctl.Kp": 500.0, "ctl.Kd": 20.0}}
    events = (*review.events, advice)
    other = StudyReview(review.file, review.location, review.runs, events)
    assert "<span class=small>not run on the axis; expected" in study_page(other)


def test_the_page_loads_nothing_and_its_links_lead_somewhere(read: PageText) -> None:
    assert not {"link", "img", "iframe", "object", "base"} & set(read.tags)
    links = [value for name, value in read.attributes if name in ("src", "href", "style")]
    anchors = {value for name, value in read.attributes if name == "id"}
    assert all(value[0] == "#" and value[1:] in anchors for value in links)
    for word in ("url(", "@import", "fetch(", "XMLHttpRequest", "import("):
        assert word not in read.embedded[""]


def test_a_thousand_runs_give_a_page_of_a_few_megabytes(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "large.study", twin_runs=1000)
    with made.store:
        for _ in range(4):
            made.trial("IS2", made.gains())
        review = StudyReview.read(tmp_path / "large.study")
    many = tuple(
        replace(run, trial=replace(run.trial, number=4 * block + run.trial.number))
        for block in range(250)
        for run in review.runs
    )
    page = study_page(StudyReview(review.file, review.location, many, review.events))
    assert len(json.loads(PageText(page).embedded["trajectories"])["runs"]) == 1000
    assert len(page.encode()) < 4_000_000


def test_a_gain_with_a_range_of_the_twin_file_is_not_told_to_lie_at_the_end_of_its_runs(
    tmp_path: Path,
) -> None:
    made = ExampleStudy(tmp_path / "example.study")
    with made.store as store:
        for share in (0.2, 0.8):
            gains = {name: low + share * (high - low) for name, (low, high) in made.box.items()}
            made.real(gains, None)
        review = StudyReview.read(tmp_path / "example.study")
        unknown = replace(review, file=review.file.model_copy(update={"gains": {}}))
        assert not any("end of its range" in told for told in study_remarks(unknown))
        assert unknown.space.names == tuple(made.box)  # the map has the range of the runs
        # Control: with the range in its log it is known, and so is an end that was reached.
        ranges = {"scale": "linear", "integer": False, "values": []}
        box = [{"name": n, "low": 0.0, "high": gains[n], **ranges} for n in made.box]
        store.log("begin", origin="..", twins={}, box=box)
    logged = StudyReview.read(tmp_path / "example.study")
    assert [gain.low for gain in logged.space.gains] == [0.0, 0.0]
    assert sum("upper end of its range [0, " in told for told in study_remarks(logged)) == 2
