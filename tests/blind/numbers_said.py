"""Numbers of a diagnosis against the truth: parameters, their intervals, errors on unseen runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

MODELS = ("nominal", "parameters_only", "unnamed_spline", "augmented")


@dataclass(frozen=True)
class Numbers:
    """What can be held against the truth; empty where there is nothing to compare.

    Attributes
    ----------
    errors : tuple of (str, float)
        `effect.parameter` of rightly named laws, and the relative error of its value; sine and
        cosine amplitudes as one.
    covered : tuple of (str, bool)
        The same, one by one, and whether the 95 % interval holds the true value.
    twin_errors : tuple of (str, float)
        The twin's own parameters, relative, where the physics is right.
    twin_covered : tuple of (str, bool)
        Whether their intervals hold the true value.
    held_out : dict of str to float
        Errors on held-out recordings over the noise floor, by model of `MODELS`: root of the
        mean square over the signals.
    """

    errors: tuple[tuple[str, float], ...] = ()
    covered: tuple[tuple[str, bool], ...] = ()
    twin_errors: tuple[tuple[str, float], ...] = ()
    twin_covered: tuple[tuple[str, bool], ...] = ()
    held_out: tuple[tuple[str, float], ...] = ()


def judge_numbers(answer: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> Numbers:
    """Compare what a diagnosis says with the answer.

    Parameters
    ----------
    answer : mapping
        Of `cases.Answer`.
    diagnosis : mapping
        Content of diagnosis.json.
    """
    said = {effect["name"]: effect.get("parameters") or {} for effect in diagnosis["effects"]}
    true = {effect["name"]: effect.get("values", {}) for effect in answer["effects"]}
    errors: list[tuple[str, float]] = []
    covered: list[tuple[str, bool]] = []
    for name in sorted(set(said) & set(true)):
        values = {key: entry["value"] for key, entry in said[name].items()}
        errors += [(f"{name}.{key}", e) for key, e in _relative(values, true[name]).items()]
        covered += [
            (f"{name}.{key}", _holds(said[name][key], value))
            for key, value in true[name].items()
            if key in said[name]
        ]
    twin_errors, twin_covered = _of_the_twin(answer, diagnosis, set(said) == set(true))
    return Numbers(tuple(errors), tuple(covered), twin_errors, twin_covered, _held_out(diagnosis))


def _relative(said: Mapping[str, float], true: Mapping[str, float]) -> dict[str, float]:
    errors = {}
    for key, value in true.items():
        if key not in said:
            continue
        if key.startswith("sine"):
            other = key.replace("sine", "cosine")
            wanted = np.hypot(value, true[other])
            given = np.hypot(said[key], said.get(other, 0.0))
            errors[key.replace("sine", "amplitude")] = float(abs(given / wanted - 1.0))
        elif not key.startswith("cosine") and value != 0.0:
            errors[key] = abs(float(said[key]) / value - 1.0)
    return errors


def _holds(entry: Mapping[str, Any], value: float) -> bool:
    low, high = entry.get("low"), entry.get("high")
    return low is not None and high is not None and low <= value <= high


def _of_the_twin(
    answer: Mapping[str, Any], diagnosis: Mapping[str, Any], physics_is_right: bool
) -> tuple[tuple[tuple[str, float], ...], tuple[tuple[str, bool], ...]]:
    if not physics_is_right or answer["kind"] == "outside":
        return (), ()
    found = diagnosis.get("parameters") or {}
    shared = [name for name in answer["parameters"] if (found.get(name) or {}).get("value")]
    true = {name: answer["parameters"][name]["true"] for name in shared}
    return (
        tuple((name, abs(found[name]["value"] / true[name] - 1.0)) for name in shared),
        tuple(
            (name, _holds(found[name], true[name]))
            for name in shared
            if found[name].get("identifiable", True)
        ),
    )


def _held_out(diagnosis: Mapping[str, Any]) -> tuple[tuple[str, float], ...]:
    signals = ((diagnosis.get("fit") or {}).get("signals") or {}).values()
    return tuple(
        (model, float(np.sqrt(np.mean([(s[model] / s["noise_floor"]) ** 2 for s in signals]))))
        for model in MODELS
        if signals and all(s.get(model) is not None and s.get("noise_floor") for s in signals)
    )
