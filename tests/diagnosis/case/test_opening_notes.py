"""A start that the twin file wants fitted stays where it is, and a note says so."""

from __future__ import annotations

from gmfbo import FmuTwin, models_folder
from gmfbo.diagnosis.case.opening_notes import starts_not_fitted


def test_a_start_that_is_not_fitted_is_told_with_where_it_stays() -> None:
    with FmuTwin(models_folder() / "linear_axis.toml") as twin:
        name = next(iter(twin.file.uncertain))
        changed = twin.with_file(twin.file.model_copy(update={"initial": {name: "fit"}}))
        (note,) = starts_not_fitted(changed)
        assert note.startswith(f'[initial] {name} = "fit" is not fitted: runs start at the FMU')
        stated = twin.file.model_copy(update={"initial": {name: 0.1}})
        assert starts_not_fitted(twin.with_file(stated)) == []
