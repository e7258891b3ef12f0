"""Starts of a limit to which what the bare twin leaves points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from gmfbo import FmuTwin, Recording, models_folder
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.comparison.moves import ranked, responses
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.starting.pointed_starts import pointed_starts
from gmfbo.diagnosis.runs.measured_excitation import demands, states_of
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

TIME = np.linspace(0.0, 0.999, 1000)
WAVES = [0.3 * np.sin(2.0 * np.pi * 3.0 * TIME), 0.15 * np.sin(2.0 * np.pi * 7.0 * TIME)]
LIMIT = "supply_voltage_limit"


def recorded(hidden: Mapping[str, float]) -> list[Recording]:
    rng = np.random.default_rng(0)
    made = []
    with AugmentedTwin(FmuTwin(models_folder() / "servo_axis.toml"), substeps=10) as axis:
        for reference in WAVES:
            wave = {"reference": reference}
            plan = axis.plan(Recording(time=TIME, signals=wave), {})
            run = axis.run(plan, {}, dict(hidden))
            noise = 1e-6 * rng.standard_normal(TIME.size)
            logged = {**wave, **run.held, "position": run.states["position"] + noise}
            made.append(Recording(time=TIME, signals=logged))
    return made


def test_of_many_starts_those_that_cut_where_the_axis_is_cut_stay() -> None:
    twin = FmuTwin(models_folder() / "servo_axis.toml")
    case = open_case(twin, recorded({}), seed=0, jobs=1)
    try:
        runs = zip(case.base.simulated, case.simulations.records, strict=True)
        excitation = case.setting.excitation
        excitation = replace(excitation, demands=demands(*(states_of(*one) for one in runs)))
    finally:
        case.simulations.close()
    slope = 0.37 * excitation.command / excitation.speed
    hidden = {"limit": 0.99 * excitation.largest_demand(slope), "slope": slope}

    axis = recorded({f"{LIMIT}.{name}": value for name, value in hidden.items()})
    case = open_case(twin, axis, seed=0, jobs=1)
    case.change_setting(replace(case.setting, excitation=excitation))
    try:
        comparison = comparison_of(case, [LIMIT])
        search = comparison.search
        ledger = search.opened(comparison.first)
        found = pointed_starts(search.problem, ledger, search.elements)
        base = ledger.rows[frozenset()]
        gains = [
            ranked(ledger.whitening, base, responses(search.problem, base, own))[0].gain
            for own in (search.elements, found)
        ]
    finally:
        case.simulations.close()
    assert gains[1] > gains[0] > 1.0  # [nats], as simulated
    slopes = [e.candidate.values["slope"] for e in found if e.candidate and e.name == LIMIT]
    assert 0 < len(slopes) <= 6
    # The slopes that are tried span a factor of 32.
    assert all(1.0 / 1.5 < own / slope < 1.5 for own in slopes)
