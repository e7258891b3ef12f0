"""Open a case as for a diagnosis, measured and aligned, with nothing fitted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.checking.row_conventions import (
    RowConvention,
    are_mixed,
    common_convention,
    row_conventions,
)
from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.locating.parities import Parities, parities
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
        where that cannot tell, and where recordings differ in it.
    rows : tuple of str
        `held` or `new`, by recording: how its command is compared.
    """

    case: Case
    checked: Parities
    logged: str | None
    rows: tuple[str, ...]

    @property
    def mixed(self) -> dict[str, tuple[str, ...]]:
        """Names of the recordings that hold each; empty where all are alike."""
        records = self.case.simulations.records
        if len(set(self.rows)) < 2:
            return {}
        return {
            which: tuple(r.name for r, own in zip(records, self.rows, strict=True) if own == which)
            for which in ("held", "new")
        }


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
        fails = checked.controller is not None and checked.controller.fails
        logged = common_convention(row_conventions(case, checked), fails=fails)
        rows = _rows(case, logged)
        if rows != case.simulations.new_rows:
            case.simulations.close()
            case = open_case(fixed, recordings, seed=seed, jobs=jobs, new_rows=rows, on_run=on_run)
            checked = parities(case, case.base)
        told = row_conventions(case, checked)
        if are_mixed(told):
            logged = None
        return NominalCase(_with_derivatives(case, twin), checked, logged, _compared_as(case, told))
    except BaseException:
        case.simulations.close()
        raise


def _compared_as(case: Case, told: Sequence[RowConvention | None]) -> tuple[str, ...]:
    """Convention of each recording: its own where recordings clearly differ, else that of all."""
    common = "new" if command_of(case) in case.simulations.new_rows else "held"
    if not are_mixed(told):
        return (common,) * len(told)
    return tuple(own.which if own is not None and own.is_clear else common for own in told)


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
