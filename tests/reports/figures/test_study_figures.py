"""Figures of a study: what they draw is what the store holds."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import InputError
from gmfbo.reports.study.review import StudyReview
from tests.reports.study.example_studies import TIME, ExampleStudy, write_example_study

pytest.importorskip("matplotlib")
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gmfbo.reports.figures.figure_style import METHOD_COLOURS, save_figure
from gmfbo.reports.figures.study_figures import (
    best_observed,
    draw_study,
    gains,
    mismatch_and_trust,
    sampling_cost,
)
from gmfbo.reports.figures.trajectory_figure import trajectories


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> StudyReview:
    return StudyReview.read(write_example_study(tmp_path_factory.mktemp("studies")))


def drawn(axes: Axes, label: str) -> tuple[list[float], list[float]]:
    """Points of the line of that name."""
    (line,) = [line for line in axes.get_lines() if line.get_label() == label]
    return list(np.asarray(line.get_xdata())), list(np.asarray(line.get_ydata()))


def test_every_real_run_and_the_best_so_far_are_drawn(review: StudyReview) -> None:
    left, right = best_observed(review).axes
    objectives = [run.trial.objective for run in review.real]
    assert drawn(left, "real runs") == ([1.0, 2.0, 3.0, 4.0, 5.0], objectives)
    costs = [run.cost for run in review.real]
    assert drawn(right, "real runs") == (costs, objectives)
    so_far = [np.inf if run.trial.status != "ok" else run.trial.objective for run in review.real]
    assert drawn(left, "best so far")[1] == np.minimum.accumulate(so_far).tolist()


def test_each_query_stands_at_the_cost_of_all_runs_up_to_its_end(review: StudyReview) -> None:
    (axes,) = sampling_cost(review).axes
    # 8 twin runs; each real run with one of the twin and two corrected ones; one twin query, and
    # 5 runs made again.
    ends = [0.8 + 2 * 1.3, 0.8 + 3 * 1.3, 1.4 + 3 * 1.3, 1.4 + 4 * 1.3, 1.4 + 5 * 1.3]
    query, cost = drawn(axes, "all runs")
    assert query == [0, 1, 2, 3, 4]
    assert cost == pytest.approx(ends)
    assert drawn(axes, "asked: twin (IS2)")[0] == [2]
    assert drawn(axes, "asked: twin (IS2)")[1] == pytest.approx([ends[2]])
    assert drawn(axes, "asked: real axis (IS1)")[0] == [1, 3, 4]


def test_mismatch_and_trust_are_those_of_the_log(review: StudyReview) -> None:
    left, middle, right = mismatch_and_trust(review).axes
    np.testing.assert_array_equal(left.get_lines()[0].get_ydata(), [1.5, 1.25, 0.5, 0.125])
    length = drawn(middle, "lengthscale between the sources")
    assert length == ([1.0, 2.0, 3.0, 4.0], [1 / 1.5, 0.8, 1.0, 1.0])
    assert drawn(middle, "price of a query of the twin")[1] == [1.0, 1.0, 0.5, 0.125]
    assert drawn(right, "twin")[1] == [0.1] * 5
    real = [run.trial.number for run in review.real]
    assert drawn(right, "corrected, held out")[1] == [0.001 * number for number in real]
    assert right.get_ylabel() == "RMS error of position [rad]"


@pytest.mark.parametrize("offset", [0, 1, 2])
def test_any_run_leads_to_its_real_one_with_twin_and_band(review: StudyReview, offset: int) -> None:
    real = review.real[2].trial
    above, below = trajectories(review, real.number + offset).axes
    measured = drawn(above, f"real axis (IS1), run {real.number}")
    assert measured == (list(TIME), list(real.recording.signal("position")))
    twin = review.trials[real.number + 1].recording.signal("position")
    assert drawn(above, f"twin (IS2), run {real.number + 1}")[1] == list(twin)
    left = np.asarray(below.get_lines()[0].get_ydata())
    np.testing.assert_allclose(left, real.recording.signal("position") - twin)
    (band,) = above.collections
    corrected = review.trials[real.number + 2]
    edge = np.asarray(band.get_paths()[0].vertices)[:, 1]
    top = corrected.recording.signal("position").max() + 1.96 * 0.01
    assert edge.max() == pytest.approx(top)


@pytest.mark.parametrize(("count", "panels"), [(1, 1), (2, 1), (3, 3)])
def test_gains_of_every_source_are_drawn(tmp_path: Path, count: int, panels: int) -> None:
    review = StudyReview.read(write_example_study(tmp_path, gains=count))
    figure = gains(review)
    axes = [one for one in figure.axes if one.get_xlabel()]
    assert len(axes) == panels
    kp = [run.trial.gains["ctl.Kp"] for run in review.real]
    assert drawn(axes[0], "real axis (IS1)")[0] == kp
    assert axes[0].get_xlabel() == "ctl.Kp [unit of the FMU]"


@pytest.mark.parametrize("count", [1, 2])
def test_a_gain_has_the_unit_that_was_logged(tmp_path: Path, count: int) -> None:
    read = StudyReview.read(write_example_study(tmp_path, gains=count))
    begun = {"event": "begin", "origin": "..", "twins": {}, "units": {"ctl.Kp": "N.m/rad"}}
    known = dataclasses.replace(read, events=(*read.events, begun))
    labels = [axes.get_xlabel() for axes in gains(known).axes]
    assert "ctl.Kp [N m/rad]" in [label.replace("\u00a0", " ") for label in labels]


def test_every_axis_of_every_figure_has_a_unit(review: StudyReview) -> None:
    figures: list[Figure] = [
        best_observed(review), sampling_cost(review), mismatch_and_trust(review),
        trajectories(review), trajectories(review, signal="torque_command"), gains(review),
    ]  # fmt: skip
    for figure in figures:
        for axes in figure.axes:
            for label in (axes.get_xlabel(), axes.get_ylabel()):
                assert not label or ("[" in label and label.endswith("]")), label
        assert any(axes.get_xlabel() for axes in figure.axes)


@pytest.mark.slow
def test_all_figures_are_written_as_pdf_and_svg(review: StudyReview, tmp_path: Path) -> None:
    first = draw_study(review, tmp_path / "a")
    assert {path.stem for path in first} == {
        "best_observed", "gains", "mismatch_and_trust", "sampling_cost", "trajectories"
    }  # fmt: skip
    assert {path.suffix for path in first} == {".pdf", ".svg"}
    again = save_figure(sampling_cost(review), tmp_path / "b" / "sampling_cost.pdf")
    assert again.read_bytes() == (tmp_path / "a" / "sampling_cost.pdf").read_bytes()


def luminance(colour: str) -> float:
    """Relative luminance of sRGB, WCAG 2.1."""
    parts = [int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return sum(w * p for w, p in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_lines_stand_out_from_white_paper() -> None:
    for colour in METHOD_COLOURS:
        assert 1.05 / (luminance(colour) + 0.05) > 2.2, colour


def test_what_cannot_be_drawn_is_refused_with_a_cure(review: StudyReview, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a real run or one that belongs to it, got 99"):
        trajectories(review, 99)
    with pytest.raises(InputError, match="got 'speed'; known are position"):
        trajectories(review, signal="speed")
    with pytest.raises(InputError, match=r"to end in \.pdf, \.svg, \.png"):
        save_figure(sampling_cost(review), tmp_path / "x.gif")
    made = ExampleStudy(tmp_path / "new.study")
    with made.store:
        made.trial("IS2", made.gains())
        begun = StudyReview.read(tmp_path / "new.study")
    with pytest.raises(InputError, match="expected a study with a real run, got none"):
        best_observed(begun)
    with pytest.raises(InputError, match="expected a study whose method corrects its twin"):
        mismatch_and_trust(begun)
