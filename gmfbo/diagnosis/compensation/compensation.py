"""Make a drive's feed-forward from a diagnosis, to cancel the left-out physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.compensation.laws import ADVICE, REST_SHARE, Ground, compensating_tables
from gmfbo.diagnosis.compensation.table import Compensation, CompensationTable, NotCompensated
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.result.certainty import is_sure, set_words
from gmfbo.diagnosis.result.named_effect import NamedEffect
from gmfbo.diagnosis.result.predictions import Predictions, Span
from gmfbo.errors import InputError
from gmfbo.plain_words import probability, words
from gmfbo.units import parse_unit

_CURVE_LEFT_OUT = (
    "the curve in the report was fitted beside other values of the named laws: it is not cancelled "
    "with them"
)

_OLDER_RANGE = (
    "this older diagnosis does not say how fast the axis moved: tables over the velocity reach to "
    "125 times the smoothing and stay constant beyond"
)
_OLDER = "its table needs more than this older diagnosis holds: diagnose again"


def compensation_of(
    diagnosis: Diagnosis, name: str, smoothing: float | None = None
) -> Compensation:
    """Turn the named effects of a diagnosis into tables that a drive can look up.

    Parameters
    ----------
    diagnosis : Diagnosis
        Its effects are missing from the twin, so the axis has them.
    name : str
        Folder of the diagnosis, for the header.
    smoothing : float, optional
        [velocity] Half width over which the sign of the velocity rises from -1 to 1; 1 % of the
        fastest recorded motion unless given.

    Returns
    -------
    Compensation
        At least one table.

    Raises
    ------
    InputError
        No named effect can be cancelled, or the diagnosis is of a version that did not save how
        fast the axis moved and no smoothing is given.
    """
    if smoothing is not None and not (np.isfinite(smoothing) and smoothing > 0.0):
        raise InputError(f"--smoothing: expected a velocity above zero, got {smoothing:g}")
    told = diagnosis.predictions
    ground = (
        _older_ground(diagnosis, name, smoothing)
        if told is None
        else _ground(told.spans, smoothing)
    )
    tables: list[CompensationTable] = []
    left: list[NotCompensated] = []
    for effect in diagnosis.effects:
        _require_numbers(effect, name)
        try:
            found = compensating_tables(effect.name, _values(effect, told), ground)
        except KeyError:  # a range or a fixed value that an older diagnosis does not hold
            if told is not None:
                raise
            left.append(NotCompensated(effect.name, _OLDER))
            continue
        tables += found
        if not found:
            left.append(NotCompensated(effect.name, ADVICE.get(effect.name, "tune with it")))
    curve = _unnamed(diagnosis, ground)
    remarks = _remarks(diagnosis)
    if told is None:
        remarks += (_OLDER_RANGE,)
    if curve and tables:
        remarks += (_CURVE_LEFT_OUT,)
    tables = tables or curve
    if not tables:
        raise InputError(_nothing(diagnosis, name, left))
    return Compensation(name, tuple(tables), tuple(left), ground.units, remarks)


def _ground(spans: Mapping[str, Span], smoothing: float | None) -> Ground:
    speed = max(abs(spans["velocity"].low), abs(spans["velocity"].high), 1e-12)
    units = {name: span.unit for name, span in spans.items()}
    units |= {"reference": units["position"], "acceleration": f"{units['position']}/s2"}
    return Ground(spans, smoothing or REST_SHARE * speed, units)


def _older_ground(diagnosis: Diagnosis, name: str, smoothing: float | None) -> Ground:
    """Ground of a diagnosis without recorded ranges: the smoothing tells the fastest motion."""
    if smoothing is None:
        raise InputError(
            f"{name}: this older diagnosis does not say how fast the axis moved; give --smoothing "
            "VELOCITY, 1 % of the fastest motion, or diagnose again"
        )
    units = {one.unit for effect in diagnosis.effects for one in effect.parameters.values()}
    if diagnosis.shape is not None:
        units |= {diagnosis.shape.unit_x, diagnosis.shape.unit_y}
    parsed = {unit: parse_unit(unit) for unit in units if unit not in ("", "1")}
    other = sorted(unit for unit, one in parsed.items() if one is None or not one.is_si)
    if other:
        raise InputError(
            f"{name}: expected values in SI units of a diagnosis that does not say how fast the "
            f"axis moved, got {', '.join(other)}; diagnose again"
        )
    turns = any("rad" in unit or "N.m" in unit for unit in units)
    length, torque = ("rad", "N.m") if turns else ("m", "N")
    fastest = smoothing / REST_SHARE
    known = {"velocity": Span(-fastest, fastest, f"{length}/s")}
    more = {"position": length, "torque": torque, "reference": length}
    return Ground(known, smoothing, {"velocity": f"{length}/s", **more})


def _require_numbers(effect: NamedEffect, name: str) -> None:
    for parameter, one in effect.parameters.items():
        if not np.isfinite(one.value):
            raise InputError(
                f"{name}: expected a number for {parameter} of {words(effect.name)}, got none; "
                "diagnose again"
            )


def _values(effect: NamedEffect, told: Predictions | None) -> dict[str, float]:
    """Identified parameter values, with the fixed ones where they were saved."""
    head = f"{effect.name}."
    physics = {} if told is None else told.explanations[0].physics
    fixed = {
        name.removeprefix(head): value for name, value in physics.items() if name.startswith(head)
    }
    return {**fixed, **{name: one.value for name, one in effect.parameters.items()}}


def _unnamed(diagnosis: Diagnosis, ground: Ground) -> list[CompensationTable]:
    """The inferred curve, where no law of the library explains the recordings."""
    shape = diagnosis.shape
    if shape is None or shape.port != "torque" or shape.against not in ("velocity", "position"):
        return []
    x, first = np.unique(np.asarray(shape.x, dtype=np.float64), return_index=True)
    y = -np.asarray(shape.y, dtype=np.float64)[first]
    known = np.isfinite(x) & np.isfinite(y)
    table = ground.table("inferred_curve", "torque", shape.against, x[known], y[known])
    told = "a curve that was inferred, no law: look at its band in the report first"
    return [replace(table, unit_x=shape.unit_x, unit_y=shape.unit_y, remark=told)]


def _remarks(diagnosis: Diagnosis) -> tuple[str, ...]:
    sets = tuple(
        f"{words(effect.name)} cannot be told from "
        f"{words(', '.join(effect.indistinguishable_from))}: this cancels the former"
        for effect in diagnosis.effects
        if effect.indistinguishable_from
    )
    weak = tuple(
        f"{set_words(effect)} has a probability of {probability(effect.set_probability)} only: "
        "see on the axis whether this helps"
        for effect in diagnosis.effects
        if not is_sure(effect.set_probability)
    )
    return sets + weak


def _nothing(diagnosis: Diagnosis, name: str, left: list[NotCompensated]) -> str:
    expected = f"{name}: expected a diagnosis of something that a feed-forward can cancel, "
    if left:
        told = "; ".join(f"{words(entry.effect)}: {entry.advice}" for entry in left)
        return f"{expected}it named only {told}"
    if diagnosis.verdict == "outside_library":
        return f"{expected}it found physics outside the library that is no function of one state"
    return f"{expected}it named nothing; use the twin's parameters as they were refitted"
