"""Tables of the comparisons of tuning methods."""

from __future__ import annotations

from collections.abc import Sequence

from tests.benchmarks.tables.results import MADE, Compared, commands, compared, fewer_runs

DESCRIBED = {
    "gmfbo_physics": "then the default",
    "gmfbo": "twin corrected, not explained",
    "gmfbo_paper": "as published",
    "bo_ei": "no twin",
    "twin_once": "best gains of the twin",
}
STUDIES = ("noise_50", "missing_physics", "hardware_like", "friction_doubling")
METHODS = (
    "gmfbo_physics", "gmfbo", "gmfbo_paper", "mfbo_caei", "mfbo_takg", "bo_ei", "twin_once",
    "random",
)  # fmt: skip
NOISE = ("noise_25", "noise_50", "noise_75")
NOISY_METHODS = ("gmfbo_physics", "gmfbo", "gmfbo_paper", "mfbo_takg", "bo_ei")
INITIAL = ("1_10", "2_10", "3_10", "4_10", "5_10", "10_10", "2_5", "2_20", "2_30")
INITIAL_METHODS = ("gmfbo", "gmfbo_paper", "mfbo_takg", "bo_ei")


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    bar = "|" + "---|" * len(head)
    lines = [_line(head), bar, *map(_line, rows)]
    return "\n".join(lines) + "\n"


def _line(cells: Sequence[str]) -> str:
    return "|" + "".join(f" {cell} |" if cell else " |" for cell in cells)


def all_methods() -> str:
    """Every method in the four main studies."""
    found = [compared(study) for study in STUDIES]
    most = [max(one.seeds for one in methods.values()) for methods in found]
    rows = [
        [_told(method), *(_cell(one.get(method), n) for one, n in zip(found, most, strict=True))]
        for method in METHODS
    ]
    less = ["`gmfbo_physics` less `bo_ei`, same seed, mean (95 %)"]
    for study in STUDIES:
        mean, low, high = fewer_runs(study, "gmfbo_physics")
        less.append(f"{mean:.1f} ({low:.1f}, {high:.1f})")
    return table(["median n* (mean; never)", *(f"`{s}`" for s in STUDIES)], [*rows, less])


def _told(method: str) -> str:
    return f"`{method}`, {DESCRIBED[method]}" if method in DESCRIBED else f"`{method}`"


def _cell(one: Compared | None, seeds: int) -> str:
    """Median (mean; never), and the seeds where they are fewer than others have."""
    if one is None:
        return ""
    fewer = f"; {one.seeds} seeds" if one.seeds < seeds else ""
    return f"{one.median:.1f} ({one.mean:.1f}; {one.never} %{fewer})"


def by_noise() -> str:
    """The same drive with less and with more noise in its twin."""
    found = [compared(study) for study in NOISE]
    most = [max(one.seeds for one in methods.values()) for methods in found]
    rows = [
        [_told(method), *(_cell(one.get(method), n) for one, n in zip(found, most, strict=True))]
        for method in NOISY_METHODS
    ]
    return table(["median n* (mean; never)", "25 %", "50 %", "75 %"], rows)


def by_initial_runs() -> str:
    """The same drive with more and with fewer runs to begin with."""
    rows = []
    for name in INITIAL:
        found = compared("noise_50" if name == "2_10" else f"initial_{name}")
        most = max(found[method].seeds for method in INITIAL_METHODS)
        cells = [_cell(found[method], most) for method in INITIAL_METHODS]
        rows.append([name.replace("_", ", "), *cells])
    return table(["real, twin runs to begin with", *(f"`{m}`" for m in INITIAL_METHODS)], rows)


def made() -> str:
    """Commits, dates and the first command of each comparison."""
    rows = []
    for study, when in MADE["tuning"].items():
        asked = commands(study)
        methods = compared(study)
        rows.append(
            [
                f"[`{study}`](../../tests/benchmarks/results/{study}/table.txt)",
                f"{max(one.seeds for one in methods.values())}",
                f"`{asked[-1]}`" + (f" and {len(asked) - 1} more" if len(asked) > 1 else ""),
                when,
            ]
        )
    return table(["study", "seeds, at most", "command (the last one)", "committed"], rows)
