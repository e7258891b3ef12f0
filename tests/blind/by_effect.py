"""Results by effect, and every case that is not as it should be."""

from __future__ import annotations

from collections.abc import Sequence

from tests.blind.hidden import EFFECTS
from tests.blind.score import ABSTAIN, Scored, family

_OUTCOMES = ("right", "set", "wrong", "missed", "failed")


def by_effect(scores: Sequence[Scored]) -> str:
    """Text: outcomes of single effects, a line a name."""
    lines = [
        f"{'single effect':<29}{'cases':>6}{'< 15':>6}{'named':>7}{'15-60':>7}{'right':>6}"
        f"{'> 60':>6}" + "".join(f"{name:>7}" for name in _OUTCOMES) + f"{'exact':>7}"
    ]
    for name in EFFECTS:
        own = [s for s in scores if s.kind == "single" and s.within_reach and s.hidden == (name,)]
        if not own:
            continue
        faint = [s for s in own if s.gain < ABSTAIN]
        owed = [s for s in own if s.is_owed]
        between = [s for s in own if s not in faint and s not in owed]
        cells = [
            *(f"{len(own):>6}", f"{len(faint):>6}", f"{sum(bool(s.named) for s in faint):>7}"),
            *(f"{len(between):>7}", f"{sum(s.outcome == 'right' for s in between):>6}"),
            f"{len(owed):>6}",
            *(f"{sum(s.outcome == outcome for s in owed):>7}" for outcome in _OUTCOMES),
            f"{sum(s.outcome == 'right' and s.is_exact for s in owed):>7}",
        ]
        lines.append(f"{name:<29}" + "".join(cells))
    return "Single effects by name; on the right those with a gain above 60\n" + "\n".join(lines)


def failures(scores: Sequence[Scored]) -> str:
    """Text: every case that is not as it should be, a line each, by what was hidden."""
    lines = []
    for s in sorted(scores, key=lambda s: (s.kind, s.hidden, s.case)):
        unowed = s.can_be_named and not s.is_owed and s.outcome in ("missed", "partial")
        faults = [] if unowed or s.outcome == "right" else [str(s.outcome)]
        if s.outcome == "right" and s.can_be_named and s.gain < ABSTAIN and s.named:
            faults.append("named below 15")
        faults += ["path"] if s.path_right is False else []
        faults += ["place"] if s.place_right is False else []
        if faults:
            lines.append(_line(s, faults))
    return "Not as it should be\n" + "\n".join(lines or ["nothing"])


def _line(s: Scored, faults: Sequence[str]) -> str:
    same = {family(name) for name in s.named} & {family(name) for name in s.hidden}
    probabilities = ", ".join(f"{p:.2f}" for p, _ in s.claims)
    hidden = " + ".join(s.hidden) or ", ".join(s.details) or "-"
    return (
        f"{s.case} {s.kind:<14}{s.machine:<20}gain {s.gain:<9.4g} {hidden}; "
        f"named {' + '.join(s.named) or '-'}{f' ({probabilities})' if s.claims else ''}"
        f"{' (same family)' if same else ''}; {s.verdict or '-'}: {', '.join(faults)}"
        + (f" ({s.note})" if s.note else "")
    )
