"""A diagnosis on the disk: all files, whole, and an augmented twin that can be opened again."""

from __future__ import annotations

import gc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo.cli.diagnosis.diagnose import with_notes_of_saving
from gmfbo.cli.diagnosis.diagnosis_screen import screenful
from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.result.augmentation import Augmentation
from gmfbo.errors import InputError
from gmfbo.recordings import step_reference
from gmfbo.sources.export.export import PhysicsParameter
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin_file.twin_file import TwinFile
from tests.diagnosis.example_diagnoses import friction, nothing

ALL = ["augmented.fmu", "augmented.toml", "diagnosis.json", "report.html"]
MASS = 80.0
LEVEL = PhysicsParameter("coulomb_friction.level", 20.0, "N", "Coulomb friction")


def augmented(*physics: PhysicsParameter) -> Diagnosis:
    """Friction in the linear axis, whose mass was refitted."""
    twin = models_folder() / "linear_axis.toml"
    return replace(friction(), augmentation=Augmentation(twin, {"mass": MASS}, physics, {}, 10))


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("saved") / "new" / "folder"
    written = augmented(LEVEL).save(folder)
    assert sorted(path.name for path in written) == ALL
    return folder


def test_save_makes_the_folder_and_leaves_nothing_else(saved: Path) -> None:
    assert names(saved) == ALL


def test_a_saved_diagnosis_is_read_again_and_its_twin_opened(saved: Path) -> None:
    read = Diagnosis.from_json(saved)
    assert read == augmented(LEVEL)
    reference = step_reference(0.01, at=0.05, horizon=0.4, unit="m")
    fine = FmuTwin(models_folder() / "linear_axis.toml", step=1e-4)  # the augmented twin's own
    with read.augmented_twin() as twin, fine as original:
        rubbed = twin.run({}, reference).signal("position")
        refitted = original.run({}, reference, parameters={"mass": MASS}).signal("position")[::10]
        free = twin.run({}, reference, parameters={"physics.coulomb_friction.level": 0.0})
    assert np.abs(rubbed - refitted).max() > 1e-5
    np.testing.assert_allclose(free.signal("position"), refitted, rtol=0.0, atol=1e-9)


def test_a_fresh_augmented_twin_needs_no_folder_and_leaves_none() -> None:
    twin = augmented(LEVEL).augmented_twin()
    place = twin.binding.fmus[0].path
    assert place.is_file()
    run = twin.run({}, step_reference(0.01, at=0.05, horizon=0.2, unit="m"))
    assert run.status == "ok"
    twin.close()
    del twin
    gc.collect()
    assert not place.exists()


def test_an_augmented_twin_can_be_given_a_folder(tmp_path: Path) -> None:
    with augmented(LEVEL).augmented_twin(tmp_path) as twin:
        assert "physics.coulomb_friction.level" in twin.parameter_tunable()
    assert names(tmp_path) == ["augmented.fmu", "augmented.toml"]


def test_a_diagnosis_that_was_read_is_saved_elsewhere_with_its_twin(
    saved: Path, tmp_path: Path
) -> None:
    written = Diagnosis.from_json(saved).save(tmp_path)
    assert sorted(path.name for path in written) == ALL
    assert (tmp_path / "augmented.fmu").read_bytes() == (saved / "augmented.fmu").read_bytes()


def test_an_augmented_twin_names_its_origin_from_wherever_it_is_saved(
    saved: Path, tmp_path: Path
) -> None:
    Diagnosis.from_json(saved).save(tmp_path / "deeper")
    original = models_folder() / "linear_axis.toml"
    for folder in (saved, tmp_path / "deeper"):
        named = TwinFile.read(folder / "augmented.toml").origin
        assert named is not None
        assert not Path(named).is_absolute()
        assert (folder / named).resolve() == original.resolve()
    with (
        FmuTwin(saved / "augmented.toml") as one,
        FmuTwin(tmp_path / "deeper/augmented.toml") as other,
    ):
        assert one.content_hash == other.content_hash


def test_a_diagnosis_saved_where_it_was_read_keeps_its_twin(saved: Path, tmp_path: Path) -> None:
    Diagnosis.from_json(saved).save(tmp_path)
    Diagnosis.from_json(tmp_path).save(tmp_path)
    assert names(tmp_path) == ALL


def test_a_diagnosis_without_a_twin_removes_the_one_of_an_earlier_diagnosis(
    saved: Path, tmp_path: Path
) -> None:
    Diagnosis.from_json(saved).save(tmp_path)
    nothing().save(tmp_path)
    assert names(tmp_path) == ["diagnosis.json", "report.html"]
    with pytest.raises(InputError, match="no augmented twin"):
        Diagnosis.from_json(tmp_path).augmented_twin()


def test_a_twin_that_cannot_be_exported_leaves_a_note_in_the_files(tmp_path: Path) -> None:
    wrong = augmented(replace(LEVEL, name="coulomb_friction.bogus"))
    written = wrong.save(tmp_path)
    assert sorted(path.name for path in written) == ["diagnosis.json", "report.html"]
    (note,) = [note for note in Diagnosis.from_json(tmp_path).notes if "no augmented twin" in note]
    assert "coulomb_friction.bogus" in note
    assert "no augmented twin was written" in (tmp_path / "report.html").read_text("utf-8")
    shown = screenful(with_notes_of_saving(wrong, tmp_path), written)
    assert any(line.startswith("note         no augmented twin was written: ") for line in shown)


def test_a_folder_that_cannot_be_made_is_refused_in_words(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match=r"cannot write .*a part of the path is a file"):
        nothing().save(tmp_path / "file" / "below")


def test_what_was_said_of_an_earlier_diagnosis_goes_with_it(tmp_path: Path) -> None:
    told = tmp_path / "confirmation.json"
    friction().save(tmp_path)
    told.write_text("{}")
    friction().save(tmp_path)
    assert told.exists(), "the same diagnosis again"
    nothing().save(tmp_path)
    assert not told.exists()
