"""The picture of a recording and its simulations: each compared signal, and what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.objective.fit import compare_at, nrmse, scored_rows
from gmfbo.pages.html_page import page, page_file, paragraph, section, table
from gmfbo.pages.signal_panel import RECORDED, SignalPanel, panel_figures, panels_json
from gmfbo.plain_words import listed, percent, words
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.version import __version__

_STYLES = {RECORDED: "recorded", "nominal": "before", "twin": "after"}


@dataclass(frozen=True, eq=False)
class Simulated:
    """A recording with the runs of one twin, or of an augmented twin and the one it came from.

    Attributes
    ----------
    twin : str
        Name of the twin.
    recorded : Recording
        In SI, as it was compared.
    run : Trajectory
        Of the twin.
    compared : tuple of str
        Signals that both hold, in the order of the twin file.
    warmup : float
        [s] Start of the recording that is not scored.
    nominal : Trajectory or None
        Run of the twin from which an augmented one was made.
    nominal_name : str
        Name of that twin.
    remarks : tuple of str
        Lines for the reader: what is not compared, and how the recording was read.
    settings : mapping of str to (float or str)
        FMU parameters that were given for these runs.
    """

    twin: str
    recorded: Recording
    run: Trajectory
    compared: tuple[str, ...]
    warmup: float = 0.0
    nominal: Trajectory | None = None
    nominal_name: str = ""
    remarks: tuple[str, ...] = ()
    settings: Mapping[str, float | str] | None = None

    @property
    def runs(self) -> dict[str, Trajectory]:
        """Run by model; the nominal one first, if there is one."""
        before = {} if self.nominal is None else {"nominal": self.nominal}
        return {**before, "twin": self.run}

    @property
    def legend(self) -> dict[str, str]:
        """Words by model."""
        own = "twin" if self.nominal is None else "augmented twin"
        return {RECORDED: "recorded", "nominal": "twin as it came", "twin": own}

    def error(self, model: str, signal: str) -> float:
        """NRMSE of a signal, dimensionless; NaN where it has none.

        Parameters
        ----------
        model : str
            Key of `runs`.
        signal : str
            One of `compared`.
        """
        try:
            return nrmse(self.runs[model], self.recorded, signal, warmup=self.warmup)
        except RecordingError:
            return float("nan")  # it never moves, or its run ended early


def simulation_page(simulated: Simulated) -> str:
    """Write the page.

    Parameters
    ----------
    simulated : Simulated
        With at least one compared signal.

    Returns
    -------
    str
        HTML with its style, drawings and script in it; every text is escaped.
    """
    panels = [_panel(simulated, signal) for signal in simulated.compared]
    figures = panel_figures(panels)
    drawn = f'<div class="panels">{figures[0]}</div>'
    if figures[1:]:
        drawn += (
            '<details class="more-panels" open><summary>Other signals</summary>'
            f"{''.join(figures[1:])}</details>"
        )
    recording = simulated.recorded.name or "recording"
    body = [
        f"<main><h1>{escape(_headline(simulated))}</h1>",
        f'<p class="lead">{escape(simulated.twin)} beside {escape(recording)}.</p>',
        drawn,
        section("Errors", _errors(simulated), paragraph(_what_errors_are(simulated), "soft")),
        section("Remarks", *(paragraph(remark) for remark in _remarks(simulated))),
        f"<footer><p>{escape(_footer(simulated))}</p></footer></main>",
        panels_json(panels),
    ]
    return page(
        f"{simulated.twin} beside {recording}",
        "\n".join(filter(None, body)),
        styles=(page_file("style.css"),),
        scripts=(page_file("charts.js"), page_file("panels.js")),
    )


def _headline(simulated: Simulated) -> str:
    told = []
    for signal in simulated.compared:
        after = percent(simulated.error("twin", signal))
        change = after
        if simulated.nominal is not None:
            change = f"{percent(simulated.error('nominal', signal))} before, {after} now"
        told.append(f"{words(signal)} {change}")
    return f"What is left of the recorded range: {listed(told)}"


def _panel(simulated: Simulated, signal: str) -> SignalPanel:
    recorded = simulated.recorded
    values = {RECORDED: recorded.signal(signal)}
    for model, run in simulated.runs.items():
        values[model] = values[RECORDED] - compare_at(run, recorded, signal)
    return SignalPanel(
        signal=words(signal),
        recording=recorded.name or "recording",
        part="",
        unit=recorded.units.get(signal, ""),
        time=recorded.time,
        values=values,
        drawn=(RECORDED, *simulated.runs),
        errors=tuple(simulated.runs),
        styles=_STYLES,
        words=simulated.legend,
        windows=tuple(_not_scored(simulated, signal)),
        windows_mean="shaded: not scored",
    )


def _not_scored(simulated: Simulated, signal: str) -> list[tuple[float, float]]:
    """[s] Start and end of the recording outside the scored rows; single blank cells stay."""
    time = simulated.recorded.time
    rows = np.flatnonzero(scored_rows(simulated.recorded, signal, warmup=simulated.warmup))
    if not rows.size:
        return [(float(time[0]), float(time[-1]))]
    known = np.flatnonzero(np.isfinite(simulated.recorded.signal(signal)))
    first, last = int(rows[0]), int(rows[-1])
    ends = []
    if first > known[0]:
        ends.append((float(time[0]), float(time[first])))
    if last < known[-1]:
        ends.append((float(time[last]), float(time[-1])))
    return ends


def _errors(simulated: Simulated) -> str:
    models = list(simulated.runs)
    rows = [
        [escape(words(s)), *(escape(percent(simulated.error(m, s))) for m in models)]
        for s in simulated.compared
    ]
    heads = ["signal", *(simulated.legend[model] for model in models)]
    return table(heads, rows, numbers=tuple(range(1, len(heads))))


def _what_errors_are(simulated: Simulated) -> str:
    said = "RMS of what is left over the range of the recorded signal."
    if simulated.nominal is not None:
        said += f" Twin as it came: {simulated.nominal_name}, the origin that the twin file names."
    return said


def _remarks(simulated: Simulated) -> Sequence[str]:
    ended = [
        f"{simulated.legend[model]}: the run ended early, {run.message}"
        for model, run in simulated.runs.items()
        if run.status != "ok"
    ]
    return (*ended, *simulated.remarks)


def _footer(simulated: Simulated) -> str:
    given = ", ".join(f"{name} = {value}" for name, value in (simulated.settings or {}).items())
    recorded = simulated.recorded
    told = f"{len(recorded)} rows, {recorded.duration:g} s. gmfbo {__version__}."
    return f"With {given}. {told}" if given else told
