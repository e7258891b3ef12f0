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
from gmfbo.diagnosis.result.diagnosis_json import read_diagnosis
from gmfbo.diagnosis.result.estimated import Alignment, Combination, EstimatedParameter
from gmfbo.diagnosis.result.explained import FreeRun, Remainder, Share
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
    """{"schema": 2, "verdict": "missing_physics", "evidence": "sufficient",
 "effects": [{"name": "coulomb_friction", "port": "torque", "probability": 0.97,
   "statement": "Coulomb friction of about 0.52 N m at the motor shaft is missing from the twin.",
   "equation": "tau = -F_c * sign(omega)",
   "parameters": {"level": {"value": 0.52, "unit": "N.m", "low": 0.49, "high": 0.55}},
   "evidence": 412.0, "threshold": 18.3, "evidence_per_recording": {"rec3.csv": 300.1},
   "indistinguishable_from": [], "set": ["coulomb_friction"],
   "share": {"value": 0.97, "low": 0.95, "high": 0.98}}],
 "parameters": {"mech.J": {"nominal": 0.12, "value": 0.121, "unit": "kg.m2", "low": 0.119,
   "high": 0.123, "identifiable": true, "fixed": false, "at_bound": null,
   "drifts": {"rec0.csv": 0.118, "rec3.csv": 0.125}}},
 "combinations": [{"expression": "mech.J / mot.kt", "value": 0.119, "low": 0.118, "high": 0.12}],
 "alignment": {"torque_command": {"logged": "held", "shift": 0.0, "scale": 1.0, "offset": 0.0,
   "rival": null}},
 "detectable": {"backlash": {"gap": 8e-4, "unit": "rad"}},
 "location": {"signal_path": "plant", "region": "where the velocity changes sign",
   "times": [["rec0.csv", 0.41, 0.47]]},
 "fit": {"fitted_on": ["rec0.csv"], "held_out": ["rec3.csv"],
   "signals": {"position": {"nominal": 0.021, "parameters_only": 0.019, "augmented": 0.002,
     "unnamed_spline": 0.004, "noise_floor": 0.0018,
     "free_run": {"nominal": 0.4, "parameters_only": 0.3, "augmented": 0.02}}},
   "explainable_error_removed": 0.98},
 "shape": null, "next_experiment": null,
 "not_testable": [{"name": "sensor_lag", "why": "the twin has no sensor port"}],
 "cost": {"simulations": 612, "seconds": 14.2, "stages": {"reading": 0.1}}, "seed": 0,
 "remainder": {"share": 0.02, "port": "torque", "against": "velocity", "where": "throughout"},
 "statement_probability": 0.97, "versions": {"gmfbo": "0.1.0"}}"""
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
    share=st.none() | st.builds(Share, numbers, numbers, numbers),
)
shapes = st.builds(Shape, names, names, rows, rows, rows, rows, names, names)
free_runs = st.none() | st.builds(FreeRun, numbers, numbers, numbers)
signal_fits = st.builds(SignalFit, numbers, numbers, numbers, numbers, numbers, free_runs)
diagnoses = st.builds(
    Diagnosis,
    verdict=st.sampled_from(["none", "parameters", "missing_physics", "outside_library"]),
    evidence=st.sampled_from(["sufficient", "insufficient"]),
    effects=tuples(effects),
    parameters=mappings(
        st.builds(
            EstimatedParameter,
            *(numbers, numbers, names, numbers, numbers, st.booleans()),
            drifts=st.none() | mappings(numbers),
        )
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
    remainder=st.none()
    | st.builds(Remainder, numbers, st.none() | names, st.none() | names, names),
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


def within(published: Any, content: Any) -> bool:
    """Whether all that is published is there, with the same value; more may be."""
    if isinstance(published, dict):
        return isinstance(content, dict) and all(
            name in content and within(item, content[name]) for name, item in published.items()
        )
    if isinstance(published, list):
        return len(published) == len(content) and all(map(within, published, content))
    return bool(published == content and type(published) is type(content))


def test_json_is_the_published_layout(tmp_path: Path) -> None:
    read = Diagnosis.from_json(written(tmp_path, PUBLISHED))
    assert within(PUBLISHED, json.loads(read.to_json()))


def test_a_layout_that_lacks_a_name_is_seen(tmp_path: Path) -> None:
    """Negative control."""
    content = json.loads(Diagnosis.from_json(written(tmp_path, PUBLISHED)).to_json())
    del content["effects"][0]["share"]
    assert not within(PUBLISHED, content)


def names_of(published: Any, content: Any) -> bool:
    """Whether all published names are there; of a list or of values by name, in each entry."""
    if isinstance(published, dict) and isinstance(content, dict):
        return all(n in content and names_of(item, content[n]) for n, item in published.items())
    return True


def test_a_made_diagnosis_has_the_published_names() -> None:
    content = json.loads(friction().to_json())
    assert names_of(dict.fromkeys(PUBLISHED), content)
    assert all(
        names_of(
            PUBLISHED["effects"][0] | {"evidence_per_recording": None, "parameters": None}, one
        )
        for one in content["effects"]
    )
    assert names_of(
        PUBLISHED["fit"]["signals"]["position"] | {"free_run": None},
        content["fit"]["signals"]["position"],
    )
    assert names_of(PUBLISHED["location"], content["location"])


def test_a_set_has_the_probability_of_all_its_members() -> None:
    first, second = json.loads(rivals().to_json())["effects"]
    assert first["set_probability"] == first["probability"]
    assert second["set_probability"] == pytest.approx(
        sum(r["probability"] for r in second["rivals"])
    )
    assert second["probability"] == second["rivals"][0]["probability"]


def test_a_file_of_version_0_1_is_read_only_where_that_is_asked(tmp_path: Path) -> None:
    old = {**PUBLISHED, "schema": 1}
    path = written(tmp_path, old)
    with pytest.raises(InputError, match=r"made by gmfbo 0\.1\.0.*diagnose again"):
        Diagnosis.from_json(path)
    assert read_diagnosis(Diagnosis, path, also=(1,)).effects[0].name == "coulomb_friction"


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
        ({"schema": 3}, "expected schema 2, got 3"),
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
    with pytest.raises(InputError, match="expected schema 2, got None"):
        Diagnosis.from_json(written(tmp_path, []))
