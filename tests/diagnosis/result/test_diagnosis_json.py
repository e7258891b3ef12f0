"""`diagnosis.json`: what others read, and that nothing is lost on the way."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.result.estimated import Alignment, Combination, EstimatedParameter
from gmfbo.diagnosis.result.findings import Cost
from gmfbo.diagnosis.result.held_out_errors import Fit, SignalFit
from gmfbo.diagnosis.result.named_effect import (
    DetectableSize,
    IdentifiedValue,
    NamedEffect,
    NotTestable,
    RivalShare,
)
from gmfbo.diagnosis.result.next_experiment import NextExperiment
from gmfbo.diagnosis.result.predictions import Explanation, Predictions, Span
from gmfbo.diagnosis.result.reference_test import ResidualTest
from gmfbo.diagnosis.result.whereabouts import Location, Shape, TimeWindow
from gmfbo.errors import InputError
from tests.diagnosis.example_diagnoses import friction, nothing, outside, rivals

# What programs of others rely on: names and nesting, with a value of the right kind each.
PUBLISHED: dict[str, Any] = json.loads(
    """{"schema": 1, "verdict": "missing_physics", "evidence": "sufficient",
 "effects": [{"name": "coulomb_friction", "port": "torque", "probability": 0.97,
   "statement": "Coulomb friction of about 0.52 N m at the motor shaft is missing from the twin.",
   "equation": "tau = -F_c * sign(omega)",
   "parameters": {"level": {"value": 0.52, "unit": "N.m", "low": 0.49, "high": 0.55}},
   "evidence": 412.0, "threshold": 18.3, "evidence_per_recording": {"rec3.csv": 300.1},
   "indistinguishable_from": []}],
 "parameters": {"mech.J": {"nominal": 0.12, "value": 0.121, "unit": "kg.m2", "low": 0.119,
   "high": 0.123, "identifiable": true}},
 "combinations": [{"expression": "mech.J / mot.kt", "value": 0.119, "low": 0.118, "high": 0.12}],
 "alignment": {"torque_command": {"logged": "held", "shift": 0.0, "scale": 1.0, "offset": 0.0}},
 "detectable": {"backlash": {"gap": 8e-4, "unit": "rad"}},
 "location": {"signal_path": "plant", "region": "where the velocity changes sign",
   "times": [["rec0.csv", 0.41, 0.47]]},
 "fit": {"fitted_on": ["rec0.csv"], "held_out": ["rec3.csv"],
   "signals": {"position": {"nominal": 0.021, "parameters_only": 0.019, "augmented": 0.002,
     "unnamed_spline": 0.004, "noise_floor": 0.0018}},
   "explainable_error_removed": 0.98},
 "shape": null, "next_experiment": null,
 "not_testable": [{"name": "sensor_lag", "why": "the twin has no sensor port"}],
 "cost": {"simulations": 612, "seconds": 14.2}, "seed": 0, "versions": {"gmfbo": "0.1.0"}}"""
)

numbers = st.floats(allow_nan=True, allow_infinity=False)
names = st.text(max_size=12)
shares = st.floats(0.0, 1.0)


def mappings(values: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    return st.dictionaries(names, values, max_size=3)


def tuples(values: st.SearchStrategy[Any]) -> st.SearchStrategy[tuple[Any, ...]]:
    return st.lists(values, max_size=3).map(tuple)


rows = tuples(numbers)
effects = st.builds(
    NamedEffect,
    name=names,
    port=names,
    probability=shares,
    statement=names,
    equation=names,
    parameters=mappings(st.builds(IdentifiedValue, numbers, names, numbers, numbers)),
    evidence=numbers,
    threshold=numbers,
    evidence_per_recording=mappings(numbers),
    indistinguishable_from=tuples(names),
    rivals=tuples(st.builds(RivalShare, names, shares)),
)
shapes = st.builds(Shape, names, names, rows, rows, rows, rows, names, names)
signal_fits = st.builds(SignalFit, numbers, numbers, numbers, numbers, numbers)
diagnoses = st.builds(
    Diagnosis,
    verdict=st.sampled_from(["none", "parameters", "missing_physics", "outside_library"]),
    evidence=st.sampled_from(["sufficient", "insufficient"]),
    effects=tuples(effects),
    parameters=mappings(
        st.builds(EstimatedParameter, numbers, numbers, names, numbers, numbers, st.booleans())
    ),
    combinations=tuples(st.builds(Combination, names, numbers, numbers, numbers)),
    alignment=mappings(
        st.builds(Alignment, names, numbers, numbers, numbers, st.none() | names, mappings(numbers))
    ),
    detectable=mappings(
        st.builds(DetectableSize, names.filter(lambda name: name != "unit"), numbers, names)
    ),
    location=st.builds(
        Location,
        st.sampled_from([None, "controller", "actuator", "plant", "transmission", "sensor"]),
        names,
        tuples(st.builds(TimeWindow, names, numbers, numbers)),
    ),
    fit=st.builds(Fit, tuples(names), tuples(names), mappings(signal_fits), st.none() | shares),
    shape=st.none() | shapes,
    latent=st.none() | shapes,
    residual_tests=tuples(
        st.builds(ResidualTest, names, names, numbers, numbers, numbers, numbers)
    ),
    next_experiment=st.none()
    | st.builds(NextExperiment, names, tuples(names), numbers, numbers, mappings(names), names),
    not_testable=tuples(st.builds(NotTestable, names, names)),
    cost=st.builds(Cost, st.integers(0, 10**6), numbers, mappings(numbers)),
    seed=st.integers(),
    versions=mappings(names),
    notes=tuples(names),
    predictions=st.none()
    | st.builds(
        Predictions,
        tuples(
            st.builds(
                Explanation, names, tuples(names), mappings(numbers), mappings(numbers), numbers
            )
        ),
        numbers,
        mappings(numbers),
        mappings(st.builds(Span, numbers, numbers, names)),
        tuples(names),
    ),
)


OF_RANGES = ("at_bound", "bound", "stated", "fixed")
EXTENSIONS = (
    "notes",
    "predictions",
    "latent",
    "residual_tests",
    "converged",
    "not_compared",
    "statement_probability",
)


def written(folder: Path, content: Any) -> Path:
    path = folder / "diagnosis.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


@given(diagnosis=diagnoses)
def test_a_diagnosis_survives_its_json(
    diagnosis: Diagnosis, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = written(tmp_path_factory.mktemp("json"), diagnosis.to_json())
    again = Diagnosis.from_json(path)
    assert again.to_json() == diagnosis.to_json()
    assert again.effects == diagnosis.effects or "null" in diagnosis.to_json()


@pytest.mark.parametrize("made", [friction(), rivals(), outside()])
def test_values_without_gaps_come_back_equal(made: Diagnosis, tmp_path: Path) -> None:
    assert Diagnosis.from_json(written(tmp_path, made.to_json())) == made


def shape_of(content: Any) -> Any:
    """Names and kinds, without values; one entry stands for a list."""
    if isinstance(content, dict):
        return {name: shape_of(item) for name, item in content.items()}
    if isinstance(content, list):
        return [shape_of(content[0])] if content else []
    return "number" if isinstance(content, float) else type(content).__name__


def test_json_is_the_published_layout(tmp_path: Path) -> None:
    read = Diagnosis.from_json(written(tmp_path, PUBLISHED))
    again = json.loads(read.to_json())
    assert again.pop("notes") == []
    assert again.pop("predictions") is None
    assert again.pop("latent") is None
    assert again.pop("residual_tests") == []
    assert again.pop("converged") is True
    assert again.pop("not_compared") == []
    assert [effect.pop("rivals") for effect in again["effects"]] == [[]]
    assert [effect.pop("set") for effect in again["effects"]] == [["coulomb_friction"]]
    assert again.pop("statement_probability") == 0.97
    assert again["cost"].pop("stages") == {}
    (column,) = again["alignment"].values()
    assert (column.pop("rival"), column.pop("beyond_prior")) == (None, {})
    ends = [[one.pop(name) for name in OF_RANGES] for one in again["parameters"].values()]
    assert ends == [[None, None, "", False]]
    assert again == PUBLISHED
    assert list(again) == list(PUBLISHED)


def test_a_made_diagnosis_has_the_published_names() -> None:
    content = json.loads(friction().to_json())
    published = shape_of(PUBLISHED)
    assert [*published, *EXTENSIONS] == list(content)
    assert [effect.pop("rivals") for effect in content["effects"]] == [[]]
    assert [effect.pop("set") for effect in content["effects"]] == [["coulomb_friction"]]
    assert shape_of(content["effects"]) == shape_of(
        [{**PUBLISHED["effects"][0], "evidence_per_recording": {"rec2.csv": 1.0, "rec3.csv": 1.0}}]
    )
    assert (
        shape_of(content["fit"]["signals"]["position"]) == published["fit"]["signals"]["position"]
    )
    assert shape_of(content["location"]) == published["location"]


def test_a_shape_has_the_published_names() -> None:
    names = ["port", "against", "x", "y", "y_low", "y_high", "unit_x", "unit_y"]
    names += ["law", "law_x", "law_y"]  # empty where no law stands for the shape
    assert list(json.loads(outside().to_json())["shape"]) == names


def test_a_next_experiment_has_the_published_names() -> None:
    names = ["reference", "separates", "distance", "threshold", "predicted", "why"]
    assert list(json.loads(rivals().to_json())["next_experiment"]) == names


def test_a_number_that_is_not_finite_is_null_and_comes_back_as_nan(tmp_path: Path) -> None:
    text = nothing().to_json()
    assert json.loads(text)["fit"]["signals"]["position"]["augmented"] is None
    again = Diagnosis.from_json(written(tmp_path, text))
    assert math.isnan(again.fit.signals["position"].augmented)
    assert again.fit.explainable_error_removed is None
    unbounded = replace(nothing(), cost=Cost(1, math.inf))
    assert json.loads(unbounded.to_json())["cost"]["seconds"] is None


def test_curves_are_not_in_the_json() -> None:
    content = json.loads(friction().to_json())
    assert not {"curves", "augmentation", "exported"} & set(content)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"schema": 2}, "expected schema 1, got 2"),
        ({"verdict": "broken"}, "verdict: expected one of none, parameters"),
        ({"seed": 0.5}, "seed: expected a whole number, got 0.5"),
        ({"seed": True}, "seed: expected a whole number"),
        ({"effects": {}}, "effects: expected a list"),
        ({"parameters": []}, "parameters: expected names with values"),
        ({"parameters": {"mech.J": {"nominal": 1.0}}}, r"parameters.mech.J: expected 'value'"),
        ({"detectable": {"backlash": {"gap": 1.0}}}, "backlash: expected one size and its unit"),
        ({"location": {"signal_path": None, "times": [["a", 1.0]]}}, "expected 3 values"),
        ({"cost": {"simulations": 1, "seconds": "long"}}, "seconds: expected a number"),
    ],
)
def test_a_file_that_is_not_ours_is_refused_with_the_place(
    change: dict[str, Any], said: str, tmp_path: Path
) -> None:
    path = written(tmp_path, {**PUBLISHED, **change})
    with pytest.raises(InputError, match=said):
        Diagnosis.from_json(path)


def test_a_missing_entry_is_named(tmp_path: Path) -> None:
    content = {name: value for name, value in PUBLISHED.items() if name != "fit"}
    with pytest.raises(InputError, match=r"diagnosis\.json: expected 'fit', which is not there"):
        Diagnosis.from_json(written(tmp_path, content))


def test_a_folder_stands_for_its_file_and_a_missing_one_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no diagnosis at .*gmfbo diagnose"):
        Diagnosis.from_json(tmp_path)
    written(tmp_path, PUBLISHED)
    assert Diagnosis.from_json(tmp_path).seed == 0


def test_text_that_is_no_json_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected JSON"):
        Diagnosis.from_json(written(tmp_path, "{"))
    with pytest.raises(InputError, match="expected schema 1, got None"):
        Diagnosis.from_json(written(tmp_path, []))
