"""Tables of the blind benchmark of the diagnosis."""

from __future__ import annotations

from pathlib import Path

from tests.benchmarks.tables.results import Round, rounds
from tests.benchmarks.tables.tuning import table

README = {
    "something claimed where nothing was missing": "nulls with a claim",
    "wrong names; for unknown laws": "wrong names, all cases; outside: false names",
    "named right, where the effect was large enough to see": "gain > 60: named right",
    "physics outside the library: said so": "outside: verdict",
}
SAID = {
    "claims where nothing is missing": "nulls with a claim",
    "wrong names": "wrong names, all cases",
    "named right, above 60": "gain > 60: named right",
    "a set that holds it, above 60": "a set that holds it instead",
    "right, set or silent, 15 to 60": "gain 15 to 60: right, set or none",
    "something named, below 15": "gain < 15: something named",
    "both of two": "pairs with both named",
    "law outside the library: said so": "outside: verdict",
    "the same: another name": "outside: false names",
}
_SIZE_ERROR = "error of an effect's parameter"
PLACES = {
    "part of the loop right": "signal path right, of the named",
    "state and time right": "region and times right",
    "no answer": "failed runs",
}


def for_readme() -> str:
    """What the last round came to."""
    last = rounds()[-1]
    rows = [
        [said, "; ".join(str(last.counted[one]) for one in names.split("; "))]
        for said, names in README.items()
    ]
    removed = last.measured["explainable error removed"]
    rows.append(["explainable error removed, median", f"{100.0 * removed:.0f} %"])
    return table(["what", "result"], rows)


def what_was_said() -> str:
    """Names and claims of each round."""
    rows = [
        [
            one.made["engine"],
            *(_share(one, name) for name in SAID.values()),
            str(one.unnamed),
        ]
        for one in rounds()
    ]
    aims = ["aim", "1", "2 %", "90 %", "", "", "2 %", "85 %", "85 %", "5 %", ""]
    head = ["engine", *SAID, "unnamed claims where nothing is missing"]
    return table(head, [*rows, aims])


def _share(one: Round, name: str) -> str:
    """A count, its share, and the 95 % interval of what was owed."""
    count = one.counted[name]
    if count.hits in (0, count.cases):
        return str(count)
    share = 100.0 * count.hits / count.cases
    interval = f"; {count.low:.0f} to {count.high:.0f}" if "> 60: named" in name else ""
    return f"{count} ({share:.{0 if share >= 9.95 else 1}f} %{interval})"


def how_well() -> str:
    """Places, sizes, intervals and probabilities of each round."""
    rows = [[*_numbers(one)] for one in rounds()]
    head = [
        "engine", *PLACES, "explainable error removed, median", "error of a parameter, median",
        "95 % intervals that hold", "Brier score (always 0.95; base rate)", "simulations, median",
        "seconds, median",
    ]  # fmt: skip
    aims = ["aim", "90 %", "85 %", "0", "90 %", "10 %", "85 %", "best of the three", "", ""]
    return table(head, [*rows, aims])


def _numbers(one: Round) -> list[str]:
    told = one.measured
    brier = [told[n] for n in ("stated probabilities", "always 0.95 for a claim")]
    return [
        one.made["engine"],
        *(str(one.counted[name]) for name in PLACES.values()),
        f"{100.0 * told['explainable error removed']:.0f} %",
        f"{100.0 * told[_SIZE_ERROR]:.1f} %",
        f"{told['95 % intervals that hold: effects']:.0f} %",
        f"{brier[0]:.3f} ({brier[1]:.3f}; {told['base rate of all events']:.3f})",
        f"{told['simulations']:.0f}",
        f"{told['seconds, wall clock']:.0f}",
    ]


def made() -> str:
    """Cases, command, commits and date of each round."""
    rows = [
        [
            one.made["engine"],
            str(one.cases),
            f"[`{Path(one.file).stem}`](../../tests/benchmarks/results/{one.file})",
            f"`{one.command}`",
            one.made["committed"],
            one.made.get("remark", ""),
        ]
        for one in rounds()
    ]
    return table(["engine", "cases", "result", "command", "committed", "remark"], rows)
