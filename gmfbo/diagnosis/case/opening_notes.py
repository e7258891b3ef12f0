"""Notes on what a case leaves out: else the twin would be judged without it in silence."""

from __future__ import annotations

from gmfbo.diagnosis.case.case import Case
from gmfbo.plain_words import listed, quantity
from gmfbo.sources.twin.twin import FmuTwin


def not_scored(case: Case) -> list[str]:
    """A note where recordings have no window.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    """
    scored = {window.record for window in case.budget.windows}
    left = [r.name for k, r in enumerate(case.simulations.records) if k not in scored]
    if not left:
        return []
    return [
        f"{listed(left)}: not scored, since the recording starts in another state than the twin "
        "and ends before that is forgotten; state it in [initial], or record longer"
    ]


def starts_not_fitted(twin: FmuTwin) -> list[str]:
    """A note for each start that the twin file wants fitted: it stays where the FMU has it.

    Parameters
    ----------
    twin : FmuTwin
        With its twin file.
    """
    return [
        f'[initial] {name} = "fit" is not fitted: runs start at the FMU\'s '
        f"{quantity(twin.nominal(name), twin.binding.variables[name].variable.si_unit or '')}; "
        "name a recorded signal there, or give a number"
        for name, source in twin.file.initial.items()
        if source == "fit"
    ]
