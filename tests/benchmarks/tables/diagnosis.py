"""Tables of the registered draw of the diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import chain

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
def judged(method: str = "gmfbo") -> tuple[Judged, ...]:
    """Cases of the registered draw that a method was run on, judged.

    Parameters
    ----------
    method : str
        As `made.toml` names it.
    """
    return tuple(judge(line) for line in read_outcomes(RESULTS / MADE["draw"]["files"][method]))


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
    """What was asked of the draw, and what it came to."""
    cases = judged()
    ended, owed = _ended(cases), _owed(cases)
    nulls, outside = _ended(_of(cases, "null")), _ended(_of(cases, "outside"))
    by_kind = [sum(_is_claimed(j) for j in nulls if j.family == kind) for kind in VARIANTS]
    sets = [len(claim.members) for j in ended for claim in j.claims]
    rows = [
        ["nulls with physics claimed", "at most 2 of 280, one of a kind",
         f"{_share(nulls, _is_claimed)}; at most {max(by_kind)} of a kind"],
        ["owed, named right", "85 %", _share(owed, _is_right)],
        ["owed, right or an honest set", "93 %", _share(owed, _is_right_or_set)],
        ["members of a statement, median", "1", f"{np.median(sets):.0f}"],
        ["statements told as a set", "at most 20 %", _percent(sum(n > 1 for n in sets), len(sets))],
        ["cases with a name that is not hidden", "2 %", _share(ended, _has_false_name)],
        ["outside: said so", "80 %", _share(outside, _is_outside)],
        ["outside: a name that is not hidden", "5 %", _share(outside, _has_false_name)],
        ["95 % intervals that hold, clustered by machine and law", "from 90 % on, to 98.5 %",
         _intervals(ended)],
        ["odds, recalibrated: intercept; slope", "hold 0; 1", _recalibrated(ended)],
        ["owed: explainable error left, median; 90 %", "0.10; 0.6", _error_left(owed)],
        ["cases without an answer in 900 s", "none", f"{len(cases) - len(ended)} of {len(cases)}"],
        ["simulations; seconds of all processes, median", "", _cost(ended)],
    ]  # fmt: skip
    return table(["what", "asked", "came to"], rows)


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
    median, most = np.quantile(left, [0.5, 0.9])
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
def _stated() -> list[worth.Stated]:
    return worth.stated_in(list(read_outcomes(RESULTS / MADE["draw"]["files"]["gmfbo"])))


def odds() -> str:
    """How honest the odds of the claims of effects were, as believed and as they are told."""
    rows = [[title, *cells] for title, cells in worth.recalibrated(_stated()).items()]
    return table(["probabilities", "claims", "Brier", "intercept", "slope"], rows)


def worth_of_claims() -> str:
    """How many claims were right, by the probability that other machines give them."""
    told = worth.by_probability(_stated(), worth.of_other_machines(_stated()))
    rows = [
        [f"{low:g} to {high:g}", str(count), f"{right}: {100 * right / count:.0f} %"]
        for low, high, right, count in told
    ]
    return table(["told", "claims", "right"], rows)
