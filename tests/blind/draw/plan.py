"""Which cases a draw has: strata and kinds of nulls, before any number is drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tests.blind.draw.nulls import VARIANTS
from tests.blind.outside import LAWS_OUTSIDE
from tests.blind.plan import Plan, decoys_of, nulls_of, outside_of, pairs_of, singles_of

DEVELOPMENT = {"null": 40, "owed": 36, "outside": 13, "pair": 7, "decoy": 4}
REGISTERED = {"null": 280, "owed": 250, "outside": 90, "pair": 48, "decoy": 32}
"""Cases of each stratum; pairs and decoys as 60 to 40, as in the blind benchmark."""

DEVELOPMENT_SEED = 34

_NEVER_OWED = "sensor_offset"
"""No machine here has an absolute place, so that nothing shows it."""


@dataclass(frozen=True)
class DrawnCase:
    """One case to be made.

    Attributes
    ----------
    stratum : str
        Of `DEVELOPMENT`.
    family : str
        Kind of null; "" elsewhere.
    variant : str
        Of that kind, one of `nulls.VARIANTS`.
    plan : Plan
        Kind, machine and effects in the words of the blind benchmark.
    """

    stratum: str
    family: str
    variant: str
    plan: Plan


def draw_plan(counts: Mapping[str, int], seed: int) -> list[DrawnCase]:
    """Cases of a draw in random order; the same for the same numbers.

    Parameters
    ----------
    counts : mapping of str to int
        Cases of each stratum.
    seed : int
        Decides on order, machines and effects.
    """
    rng = np.random.default_rng([seed, 0])
    cases = [
        *_nulls(counts["null"], rng),
        *(DrawnCase("owed", "", "", plan) for plan in _owed(counts["owed"], rng)),
        *(
            DrawnCase("outside", "", "", plan)
            for plan in outside_of(counts["outside"], rng, LAWS_OUTSIDE)
        ),
        *(DrawnCase("pair", "", "", plan) for plan in pairs_of(counts["pair"], rng)),
        *(DrawnCase("decoy", "", "", plan) for plan in decoys_of(counts["decoy"], rng)),
    ]
    return [cases[index] for index in rng.permutation(len(cases))]


def _nulls(count: int, rng: np.random.Generator) -> list[DrawnCase]:
    """As many of each kind; variants of a kind, and machines of a variant, in turn."""
    shares = [count // len(VARIANTS) + (k < count % len(VARIANTS)) for k in range(len(VARIANTS))]
    cases: list[DrawnCase] = []
    for share, (family, variants) in zip(shares, VARIANTS.items(), strict=True):
        if not variants:
            plans = nulls_of(share // 2, share - share // 2, rng)
            cases += [DrawnCase("null", family, plan.kind, plan) for plan in plans]
            continue
        first = int(rng.integers(len(variants)))
        turn = {name: int(rng.integers(len(v.machines))) for name, v in variants.items()}
        for k in range(share):
            name = list(variants)[(first + k) % len(variants)]
            machines = variants[name].machines
            machine = machines[turn[name] % len(machines)]
            turn[name] += 1
            cases.append(DrawnCase("null", family, name, Plan("null", machine)))
    return cases


def _owed(count: int, rng: np.random.Generator) -> list[Plan]:
    """Each effect as often as every other, at a twin that has the port for it."""
    plans = [
        replace(plan, band="owed")
        for plan in singles_of(count + count // 8 + 16, rng)
        if plan.is_within_reach and plan.effects[0] != _NEVER_OWED
    ]
    return plans[:count]
