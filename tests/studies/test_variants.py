"""Variants of a study, by the keys and values of its file."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo import Study, campaign
from gmfbo.errors import InputError
from gmfbo.studies.variants import parse_variation, variants, variation_text
from gmfbo.tuning.study_file.study_file import parse_study
from tests.studies.small_study import write_small_study


def test_key_and_values_are_read_as_toml_and_written_back() -> None:
    text = 'is2.parameters."map.noise" = [0.25, 0.5]'
    assert parse_variation(text) == ('is2.parameters."map.noise"', [0.25, 0.5])
    for values in ([0.25, 0.5], [1, 2], ["a b", "c"], [[1.0, 2.0], [3.0, 4.0]]):
        assert parse_variation(variation_text("gains.x", values)) == ("gains.x", values)


@pytest.mark.parametrize("text", ["", "seed", "seed = 3", "seed = []", "= [1]", "a b = [1]"])
def test_what_is_no_key_with_values_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"vary: expected a key"):
        parse_variation(text)


def test_all_combinations_come_with_a_name_each(tmp_path: Path) -> None:
    study = Study.read(write_small_study(tmp_path))
    both = variants(study, {'is2.parameters."mass"': [100, 130.0], "budget.initial_is1": [1, 2]})
    assert [one.file.name for one in both] == [
        f"small,is2.parameters.mass={mass},budget.initial_is1={runs}"
        for mass in (100, 130.0)
        for runs in (1, 2)
    ]
    assert [one.file.is2.parameters["mass"] for one in both] == [100.0, 100.0, 130.0, 130.0]
    assert {one.file.budget.is1_runs for one in both} == {5}
    assert variants(study, {}) == [study]


def test_what_a_study_file_cannot_say_is_refused(tmp_path: Path) -> None:
    study = Study.read(write_small_study(tmp_path))
    with pytest.raises(InputError, match="initial_is1"):
        variants(study, {"budget.initial_is1": [0]})
    with pytest.raises(InputError, match=r"'budget\.initial_is1\.x' is no key"):
        variants(study, {"budget.initial_is1.x": [0]})


def test_campaign_over_variants_is_each_of_them_compared_and_goes_on(tmp_path: Path) -> None:
    study, told = write_small_study(tmp_path), list[str]()
    vary = {"budget.initial_is1": [1, 2]}
    first = campaign([study], ["random"], 1, vary=vary, out=tmp_path / "o", grid=5)
    again = campaign(
        [study], ["random"], 1, vary=vary, out=tmp_path / "o", grid=5, progress=told.append
    )
    assert [one.folder.name for one in again] == [
        "small,budget.initial_is1=1.compare",
        "small,budget.initial_is1=2.compare",
    ]
    assert told == []
    assert [one.text for one in first] == [one.text for one in again]
    # One initial real run less, and so one query more.
    assert [one.outcomes[0].queries for one in first] == [4, 3]


def test_studies_need_names_of_their_own(tmp_path: Path) -> None:
    study = write_small_study(tmp_path)
    with pytest.raises(InputError, match=r"a name of its own for each, got small\.compare"):
        campaign([study, study], ["random"], 1, out=tmp_path / "o")


def test_kept_trials_are_the_study_of_that_method_and_seed(tmp_path: Path) -> None:
    study = write_small_study(tmp_path)
    (result,) = campaign(
        [study], ["random"], 1, first_seed=1, out=tmp_path / "o", grid=5, keep_trials=True
    )
    kept = Study.read(result.folder / "trials" / "random-1.h5")
    assert (kept.file.seed, kept.file.method) == (1, "random")
    best = min(trial.objective for trial in kept.trials if trial.source == "IS1")
    (one,) = [one for one in result.outcomes if one.seed == 1]
    assert best == pytest.approx(one.best[-1])
    assert parse_study(kept.text, label="kept", default_name="x").budget.is1_runs == 5
