"""model.toml, and what is generated from it: variables, units, C table, model description."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import fmpy
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from fmu_build.archive import members, pack
from fmu_build.build import MODELS, TEST_FMUS
from fmu_build.declaration import read_declaration
from fmu_build.description import model_description
from fmu_build.failure import BuildError
from fmu_build.header import variables_header, variables_table
from fmu_build.units import BASE_UNITS, UNITS, parse_unit

HEAD = 'name = "m"\ndescription = "d"\ninternal_step = 1e-3\n'
GAIN = '[[variable]]\nname = "k.p"\ncausality = "parameter"\nunit = "N.m/rad"\n'
FMUS = sorted([*MODELS.glob("*.fmu"), *TEST_FMUS.glob("*.fmu")])


def declare(folder: Path, text: str) -> Path:
    path = folder / "model.toml"
    path.write_text(HEAD + text)
    return path


@pytest.mark.parametrize("path", FMUS, ids=lambda path: path.stem)
def test_fmpy_finds_no_fault(path: Path) -> None:
    assert validate_fmu(str(path)) == []


@pytest.mark.parametrize("path", FMUS, ids=lambda path: path.stem)
def test_the_description_fits_the_schema_of_the_standard(path: Path) -> None:
    document = etree.fromstring(members(path.read_bytes())["modelDescription.xml"])
    version = f"fmi{document.get('fmiVersion')[0]}"
    folder = Path(fmpy.__file__).parent / "schema" / version
    schema = etree.XMLSchema(etree.parse(str(folder / f"{version}ModelDescription.xsd")))
    assert schema.validate(document), schema.error_log


@pytest.mark.parametrize("path", sorted(MODELS.glob("*.fmu")), ids=lambda path: path.stem)
def test_capabilities_are_those_that_the_wrapper_gives(path: Path) -> None:
    offered = read_model_description(str(path)).coSimulation
    assert offered.canHandleVariableCommunicationStepSize
    assert offered.canGetAndSetFMUstate
    assert offered.canSerializeFMUstate
    assert not offered.canBeInstantiatedOnlyOncePerProcess
    assert not offered.needsExecutionTool
    assert not offered.providesDirectionalDerivative


def test_an_array_becomes_scalars_row_by_row(tmp_path: Path) -> None:
    table = GAIN + 'description = "g"\ndimensions = [2, 3]\nstart = [[1, 2, 3], [4, 5, 6]]\n'
    after = '[[variable]]\nname = "u"\ncausality = "input"\ndescription = "u"\n'
    declaration = read_declaration(declare(tmp_path, table + after))
    names = [variable.name for variable in declaration.variables]
    assert names[:4] == ["k.p[1,1]", "k.p[1,2]", "k.p[1,3]", "k.p[2,1]"]
    assert [variable.start for variable in declaration.variables[:6]] == [1, 2, 3, 4, 5, 6]
    header = variables_header(declaration)
    assert "V_k_p = 0," in header
    assert "V_u = 6," in header
    assert "N_VARIABLES = 7" in header


def test_bounds_and_starts_are_the_same_in_c_and_in_xml(tmp_path: Path) -> None:
    declaration = read_declaration(
        declare(tmp_path, GAIN + 'start = 0.1\nmin = 0.0\nmax = 0.3\ndescription = "a \\"b\\""\n')
    )
    expected = '{"k.p", "N.m/rad", 0.1, 0.0, 0.3, CAUSALITY_PARAMETER, TYPE_REAL, 0}'
    assert expected in variables_table(declaration, "guid")
    real = ET.fromstring(model_description(declaration, "guid")).find(".//Real")
    assert real is not None
    assert real.attrib == {"unit": "N.m/rad", "min": "0.0", "max": "0.3", "start": "0.1"}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (GAIN, "variable 'k.p': a description is missing"),
        (GAIN + 'description = "g"\nmini = 0\n', "unknown key 'mini'; known are causality"),
        (GAIN + 'description = "g"\nstart = 2\nmax = 1\n', r"start 2\.0 is outside \[-inf, 1.0\]"),
        (GAIN + 'description = "g"\ntype = "String"\n', "must be Real, Integer or Boolean"),
        (GAIN + 'description = "g"\ndimensions = [2]\nstart = [1]\n', "start has 1 rows"),
        (2 * (GAIN + 'description = "g"\n'), "'k.p' is declared twice"),
        (
            GAIN + 'description = "g"\n' + GAIN.replace("k.p", "k_p") + 'description = "g"\n',
            "two variables become V_k_p in C",
        ),
        (
            '[[variable]]\nname = "y"\ncausality = "output"\nstart = 1\ndescription = "y"\n',
            "an output is computed and takes no start",
        ),
        ('[[variable]]\nname = "y"\ncausality = "exit"\n', "causality must be parameter"),
        ("step = 1\n", "unknown key 'step'"),
        ("[[variable\n", "cannot be read"),
    ],
)
def test_a_faulty_declaration_is_refused_with_file_and_variable(
    tmp_path: Path, table: str, message: str
) -> None:
    with pytest.raises(BuildError, match=rf"model\.toml.*{message}"):
        read_declaration(declare(tmp_path, table))


def test_a_missing_key_is_named(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    path.write_text('name = "m"\ndescription = "d"\n')
    with pytest.raises(BuildError, match="the key 'internal_step' is missing"):
        read_declaration(path)


@pytest.mark.parametrize(
    ("unit", "powers"),
    [
        ("N.m", {"kg": 1, "m": 2, "s": -2}),
        ("kg.m2", {"kg": 1, "m": 2}),
        ("N.m/(rad/s)", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("V/(m/s)", {"kg": 1, "m": 1, "s": -2, "A": -1}),
        ("s-1", {"s": -1}),
        ("1", {}),
        ("1/s", {"s": -1}),
    ],
)
def test_a_unit_is_a_product_of_base_units(unit: str, powers: dict[str, int]) -> None:
    expected = tuple(powers.get(base, 0) for base in BASE_UNITS)
    assert parse_unit(unit).powers == expected
    assert parse_unit(unit).factor == 1.0


@given(st.lists(st.sampled_from(sorted(set(UNITS) - {"1", "%"})), min_size=1, max_size=4))
def test_a_quotient_of_equal_units_is_a_number(names: list[str]) -> None:
    product = ".".join(names)
    quotient = parse_unit(f"({product})/({product})")
    assert quotient.powers == (0,) * len(BASE_UNITS)
    assert quotient.factor == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize(
    ("unit", "message"),
    [
        ("N/m.s", "put the denominator in parentheses"),
        ("N/(m.s", "a parenthesis is not closed"),
        ("furlong", "'furlong' is unknown"),
        ("N m", "cannot read ' m'"),
        ("N.", "expected a unit at ''"),
        ("m)", r"cannot read '\)'"),
    ],
)
def test_an_unreadable_unit_is_refused(unit: str, message: str) -> None:
    with pytest.raises(BuildError, match=message):
        parse_unit(unit)


def test_an_archive_depends_on_contents_only() -> None:
    assert pack({"a": b"1", "b/c": b"2"}) == pack({"b/c": b"2", "a": b"1"})
    assert pack({"a": b"1"}) != pack({"a": b"2"})


def test_an_unknown_version_of_fmi_is_refused(tmp_path: Path) -> None:
    expected = r"fmi: expected \[2\], \[3\] or \[2, 3\], got \[2, 4\]"
    with pytest.raises(BuildError, match=expected):
        read_declaration(declare(tmp_path, "fmi = [2, 4]\n"))
