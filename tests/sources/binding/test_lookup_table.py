"""Tables of a twin: found by their indices, read after initialisation, refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin
from gmfbo.errors import InputError, TwinFileError
from gmfbo.sources.binding.lookup_table import tables_of
from gmfbo.sources.binding.table_nodes import elements, shape_of
from gmfbo.sources.fmu_file.models import models_folder
from tests.drive_twin.flux_map import nominal_table

DRIVE = models_folder() / "drive_twin.toml"


def drive_file(folder: Path, tables: str) -> Path:
    text = DRIVE.read_text(encoding="utf-8")
    fmu = (models_folder() / "drive_twin.fmu").as_posix()
    head, _, rest = text.replace('"drive_twin.fmu"', f'"{fmu}"').partition("[tables]")
    path = folder / "drive.toml"
    path.write_text(f"{head}[tables]\n{tables}\n[ports]{rest.partition('[ports]')[2]}")
    return path


def test_elements_are_sorted_row_by_row() -> None:
    names = ["a[2,1]", "a[1,2]", "a[1,1]", "a[2,2]", "ab[1,1]", "a[1]x", "a"]
    found = elements("a", names)
    assert list(found.values()) == ["a[1,1]", "a[1,2]", "a[2,1]", "a[2,2]"]
    assert shape_of(found) == (2, 2)


def test_the_nodes_in_force_are_read() -> None:
    with FmuTwin(DRIVE) as twin:
        flux_d, flux_q = tables_of(twin.binding)
        read = twin.values_at_start(flux_q.nodes)
    values = np.array([read[name] for name in flux_q.nodes]).reshape(flux_q.shape)
    assert values == pytest.approx(nominal_table()[1], abs=1e-6)
    assert (flux_d.rising, flux_q.rising) == (0, 1)


def test_what_is_added_takes_the_noise_of_a_table_back() -> None:
    noisy = {"map.noise": 0.5, "map.seed": 4.0}
    with FmuTwin(DRIVE, parameters=noisy) as twin:
        table = tables_of(twin.binding)[0]
        read = twin.values_at_start(table.nodes)
        nodes = np.array([read[name] for name in table.nodes])
        settings = table.settings(nodes, nominal_table()[0].ravel() - nodes, np.zeros(25))
        again = twin.values_at_start(table.nodes, parameters=settings)
    assert np.ptp(nodes - nominal_table()[0].ravel()) > 100.0
    assert list(again.values()) == pytest.approx(list(nominal_table()[0].ravel()), abs=1e-6)


def test_an_unknown_variable_is_named() -> None:
    with (
        FmuTwin(DRIVE) as twin,
        pytest.raises(InputError, match=r"no FMU variable 'map\.nod_d\[1,1\]'; did you mean"),
    ):
        twin.values_at_start(["map.nod_d[1,1]"])


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (
            'flux = { nodes = "map.nodes_d" }',
            r"\[tables\] 'flux' nodes: expected 3 or more variables .*did you mean 'map\.node_d'",
        ),
        (
            'flux = { nodes = "map.node_d" }',
            r"\[tables\] 'flux' nodes: expected a parameter of the FMU, .* causality local",
        ),
        (
            'flux = { nodes = "map.node_d", deltas = "cogging.phase" }',
            r"\[tables\] 'flux' deltas: expected a parameter cogging\.phase\[\.\.\.\] for each of "
            "the 25 nodes, found 2",
        ),
        (
            'flux = { nodes = "map.node_d", rises = "rows" }',
            r"unknown key 'rises'; did you mean 'rising'",
        ),
    ],
)
def test_a_table_that_does_not_fit_is_refused(tmp_path: Path, tables: str, message: str) -> None:
    with pytest.raises(TwinFileError, match=message):
        FmuTwin(drive_file(tmp_path, tables))
