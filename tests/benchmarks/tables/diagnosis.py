"""Tables of the registered draws of the diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import chain
from typing import Any

import numpy as np

from tests.benchmarks.tables.results import MADE, RESULTS
from tests.benchmarks.tables.tuning import table
from tests.blind.draw import worth
from tests.blind.draw.judging import PHYSICS_CLAIMED, Judged, judge
from tests.blind.draw.measures import NORMAL, clopper_pearson, clustered_share, recalibration
from tests.blind.draw.methods import COLUMNS
from tests.blind.draw.nulls import VARIANTS
from tests.blind.draw.outcomes import read_outcomes

Cases = Sequence[Judged]


@cache
def _lines(method: str, draw: str) -> tuple[dict[str, Any], ...]:
    return tuple(read_outcomes(RESULTS / MADE[draw]["files"][method]))


@cache
def judged(method: str = "gmfbo", draw: str = "draw") -> tuple[Judged, ...]:
    """Cases of a registered draw that a method was run on, judged.

    Parameters
    ----------
    method : str
        As `made.toml` names it.
    draw : str
        `draw`, the last one, or `first_draw`.
    """
    return tuple(judge(line) for line in _lines(method, draw))


def _of(cases: Cases, stratum: str) -> list[Judged]:
    return [j for j in cases if j.stratum == stratum]


def _ended(cases: Cases) -> list[Judged]:
    return [j for j in cases if j.outcome != "failed"]


def _owed(cases: Cases) -> list[Judged]:
    return [j for j in _of(cases, "owed") if j.is_owed]


def _count(cases: Cases, holds: Callable[[Judged], bool]) -> str:
    return f"{sum(map(holds, cases))} of {len(cases)}"


def _is_claimed(one: Judged) -> bool:
    return one.outcome in PHYSICS_CLAIMED


def for_readme() -> str:
    """The most important of them."""
    ended, owed = _ended(judged()), _owed(judged())
    counts = {
        "something claimed where nothing was missing": (_of(ended, "null"), _is_claimed),
        "a wrong name": (ended, _has_false_name),
        "named right, where the effect was large enough to see": (owed, _is_right),
        "named right, or a set that holds it": (owed, _is_right_or_set),
        "physics outside the library: said so": (_of(ended, "outside"), _is_outside),
    }
    return table(["what", "result"], [[name, _count(*one)] for name, one in counts.items()])


def _has_false_name(one: Judged) -> bool:
    return bool(one.false_names)


def _is_right(one: Judged) -> bool:
    return one.outcome == "right"


def _is_right_or_set(one: Judged) -> bool:
    return one.outcome in ("right", "set")


def _is_outside(one: Judged) -> bool:
    return one.verdict == "outside_library"


def asked() -> str:
    """What was asked of the draws, and what they came to."""
    first, second = _came_to(judged(draw="first_draw")), _came_to(judged())
    rows = [
        [what, _ASKED.get(what, ""), before, now]
        for (what, before), now in zip(first.items(), second.values(), strict=True)
    ]
    heads = (f"{draw} ({MADE[key]['engine']})" for draw, key in _DRAWS.items())
    return table(["what", "asked", *heads], rows)


_DRAWS = {"first": "first_draw", "second": "draw"}
_ASKED = {
    "nulls with physics claimed": "at most 2 of 280, one of a kind",
    "owed, named right": "85 %",
    "owed, right or an honest set": "93 %",
    "members of a statement, median": "1",
    "statements told as a set": "at most 20 %",
    "cases with a name that is not hidden": "2 %",
    "outside: said so": "80 %",
    "outside: a name that is not hidden": "5 %",
    "95 % intervals that hold, clustered by machine and law": "from 90 % on, to 98.5 %",
    "odds, recalibrated: intercept; slope": "hold 0; 1",
    "owed: explainable error left, median; 90 %": "0.10; 0.6",
    "cases without an answer in 900 s": "none",
}


def _came_to(cases: Cases) -> dict[str, str]:
    ended, owed = _ended(cases), _owed(cases)
    nulls, outside = _ended(_of(cases, "null")), _ended(_of(cases, "outside"))
    by_kind = [sum(_is_claimed(j) for j in nulls if j.family == kind) for kind in VARIANTS]
    sets = [len(claim.members) for j in ended for claim in j.claims]
    return {
        "nulls with physics claimed":
            f"{_share(nulls, _is_claimed)}; at most {max(by_kind)} of a kind",
        "owed, named right": _share(owed, _is_right),
        "owed, right or an honest set": _share(owed, _is_right_or_set),
        "members of a statement, median": f"{np.median(sets):.0f}",
        "statements told as a set": _percent(sum(n > 1 for n in sets), len(sets)),
        "cases with a name that is not hidden": _share(ended, _has_false_name),
        "outside: said so": _share(outside, _is_outside),
        "outside: a name that is not hidden": _share(outside, _has_false_name),
        "95 % intervals that hold, clustered by machine and law": _intervals(ended),
        "odds, recalibrated: intercept; slope": _recalibrated(ended),
        "owed: explainable error left, median; 90 %": _error_left(owed),
        "cases without an answer in 900 s": f"{len(cases) - len(ended)} of {len(cases)}",
        "simulations; seconds of all processes, median": _cost(ended),
    }  # fmt: skip


def _percent(count: int, total: int) -> str:
    low, high = (100.0 * bound for bound in clopper_pearson(count, total))
    return f"{count} of {total}: {100.0 * count / total:.1f} % ({low:.1f} to {high:.1f})"


def _share(cases: Cases, holds: Callable[[Judged], bool]) -> str:
    return _percent(sum(map(holds, cases)), len(cases))


def _intervals(cases: Cases) -> str:
    own = [(i, (j.machine, frozenset(j.hidden))) for j in cases for i in j.intervals]
    held = [interval.holds for interval, _ in own]
    low, high = clustered_share(held, [cluster for _, cluster in own])
    return f"{sum(held)} of {len(held)}: {100.0 * low:.1f} to {100.0 * high:.1f} %"


def _recalibrated(cases: Cases) -> str:
    claims = [c for j in cases for c in j.claims if not np.isnan(c.probability)]
    found = recalibration([c.probability for c in claims], [c.judged == "right" for c in claims])
    if found is None:
        return "not told"
    cells = [
        f"{value:.2f} ({value - NORMAL * error:.2f} to {value + NORMAL * error:.2f})"
        for value, error in zip(*found, strict=True)
    ]
    return f"{'; '.join(cells)} on {len(claims)}"


def _error_left(owed: Cases) -> str:
    left = [j.error_left for j in owed if j.error_left is not None]
    median, most = np.round(np.quantile(left, [0.5, 0.9]), 2) + 0.0
    return f"{median:.2f}; {most:.2f} on {len(left)} of {len(owed)}"


def _cost(cases: Cases) -> str:
    runs, seconds = ([getattr(j, n) for j in cases] for n in ("simulations", "cpu_seconds"))
    return f"{np.median(runs):.0f}; {np.nanmedian(seconds):.0f}"


def nulls() -> str:
    """What was said where nothing is missing, by kind."""
    rows = []
    for kind in VARIANTS:
        own = [j for j in _of(judged(), "null") if j.family == kind]
        said = [sum(j.outcome == o for j in own) for o in ("right", "told", "named", "outside")]
        rows.append([kind, str(len(own)), *map(str, said)])
    head = ["kind", "cases", "nothing, or parameters", "the wrong fixed parameter", "a name"]
    return table([*head, "something unknown"], rows)


def beside_others() -> str:
    """The draw's methods on the cases that all of them were run on."""
    methods = list(MADE["draw"]["files"])
    ran = [{j.case for j in judged(m)} for m in methods]
    common = set.intersection(*ran)
    rows = []
    for method in methods:
        own = [j for j in judged(method) if j.case in common]
        rows.append([f"`{method}`", *(cell(own) for _, cell in COLUMNS.values())])
    return table([f"on the same {len(common)} cases", *COLUMNS], rows)


def hidden_laws() -> int:
    """Number of unknown laws among the cases."""
    return len(set(chain.from_iterable(j.hidden for j in _of(judged(), "outside"))))


@cache
def _stated(draw: str) -> list[worth.Stated]:
    return worth.stated_in(_lines("gmfbo", draw))


def odds() -> str:
    """How honest the odds of the last draw's claims of effects were, by where they are from."""
    stated, first = _stated("draw"), _stated("first_draw")
    half = len(_lines("gmfbo", "draw")) // 2
    told = {
        "by the line of the first draw's claims": worth.by_line_of(first, stated),
        **worth.recalibrated(stated, half),
    }
    rows = [[title, *cells] for title, cells in told.items()]
    return table(["probabilities", "claims", "Brier", "intercept", "slope"], rows)


def worth_of_claims() -> str:
    """How many claims were right, by the probability that other machines give them."""
    rows = [
        [
            draw,
            f"{low:g} to {high:g}",
            str(count),
            f"{right}: {100 * right / count:.0f} %",
        ]
        for draw, key in _DRAWS.items()
        for low, high, right, count in worth.by_probability(
            _stated(key), worth.of_other_machines(_stated(key))
        )
    ]
    return table(["draw", "told", "claims", "right"], rows)
