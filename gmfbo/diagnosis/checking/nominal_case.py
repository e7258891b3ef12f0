"""Open a case as for a diagnosis, measured and aligned, with nothing fitted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.checking.compared_command import ComparedCommand
from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.locating.parities import CLEARLY, Parities, parities
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.uncertain import uncertain_of


@dataclass(frozen=True, eq=False)
class NominalCase:
    """A case at the twin's own values.

    Attributes
    ----------
    case : Case
        With derivatives by the uncertain parameters.
    checked : Parities
        Residuals of the parts of the loop.
    logged : str or None
        Whether the logger stores the held or the new command, by the controller's parity; None
        where that cannot tell.
    """

    case: Case
    checked: Parities
    logged: str | None


def open_nominal(
    twin: FmuTwin,
    recordings: Sequence[Recording],
    *,
    seed: int,
    jobs: int | None,
    on_run: Callable[[], None],
) -> NominalCase:
    """Run the twin as it is along its recordings; the caller closes the case's simulations.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recordings : sequence of Recording
        Runs of the real axis.
    seed : int
        Of the noise runs.
    jobs : int or None
        Simulators; None for one a processor.
    on_run : callable
        Called after each run.

    Raises
    ------
    RecordingError
        There is nothing to compare.
    SimulationError
        The twin as it is cannot follow a recording.
    """
    # A twin of which nothing is uncertain is not refitted when its case is opened.
    fixed = twin.with_uncertain({})
    case = open_case(fixed, recordings, seed=seed, jobs=jobs, on_run=on_run)
    try:
        checked = parities(case, case.base)
        logged = _logged_as(case, checked)
        rows = _rows(case, logged)
        if rows != case.simulations.new_rows:
            case.simulations.close()
            case = open_case(fixed, recordings, seed=seed, jobs=jobs, new_rows=rows, on_run=on_run)
            checked = parities(case, case.base)
        return NominalCase(_with_derivatives(case, twin), checked, logged)
    except BaseException:
        case.simulations.close()
        raise


def _logged_as(case: Case, checked: Parities) -> str | None:
    """Logging convention of the command, by the clearest recording; None where none is clear.

    A sum over all recordings would be misled by one with a shifted column.
    """
    command = command_of(case)
    if checked.controller is None or command is None or not checked.logged:
        return None
    told: list[tuple[float, float, str]] = []
    for k, run in enumerate(checked.held):
        left = {}
        for which in ("held", "new"):
            compared = ComparedCommand(case, k, command, which, checked.memories[k])
            left[which] = compared.share_left(run.response)
        if left["held"] != left["new"]:
            least, most = sorted(left.values())
            told.append((least, most, min(left, key=lambda which: left[which])))
    if not told:
        return None
    least, most, which = min(told)
    # Beside an error as large as that of a wrong controller, the smaller residual is chance.
    return which if not checked.controller.fails or most > CLEARLY * least else None


def _rows(case: Case, logged: str | None) -> frozenset[str]:
    """Outputs logged as new values, with the command corrected by the controller's parity."""
    rows, command = case.simulations.new_rows, command_of(case)
    if logged is None or command is None:
        return rows
    return rows | {command} if logged == "new" else rows - {command}


def _with_derivatives(case: Case, twin: FmuTwin) -> Case:
    """Add derivatives by the uncertain parameters, so that no effect is taken for their change."""
    setting = replace(case.setting, uncertain=uncertain_of(twin))
    # One point: the values stay, and the twin is simulated beside them for its derivatives.
    base = fit(case.misfit, Hypothesis(setting), {}, parallel=True, iterations=1)
    assert base is not None, "the same values were simulated a moment ago"
    return replace(case, twin=twin, setting=setting, base=base)
