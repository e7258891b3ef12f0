"""A diagnosis in a few lines, for a prompt and for a notebook."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from gmfbo.diagnosis.result.cautions import beside_the_verdict
from gmfbo.diagnosis.result.certainty import claim_of_set
from gmfbo.diagnosis.result.misaligned_columns import misaligned_sentence
from gmfbo.diagnosis.result.sentence import verdict_sentence
from gmfbo.plain_words import interval, percent, probability, words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.explained import FreeRun
    from gmfbo.diagnosis.result.findings import Findings
    from gmfbo.diagnosis.result.held_out_errors import SignalFit
    from gmfbo.diagnosis.result.named_effect import NamedEffect

COLUMNS = ("nominal", "parameters only", "augmented", "noise floor")
FREE_RUN = "whole, uncorrected"
"""Row of an open-loop twin over whole recordings, with nothing that corrects it."""


def _fit_cells(fit: SignalFit) -> tuple[str, str, str, str]:
    """Errors of one signal [%], in the order of `COLUMNS`."""
    return (
        percent(fit.nominal),
        percent(fit.parameters_only),
        percent(fit.augmented),
        percent(fit.noise_floor),
    )


def _free_cells(free: FreeRun) -> tuple[str, str, str, str]:
    """The same without correction, which has no noise floor."""
    return percent(free.nominal), percent(free.parameters_only), percent(free.augmented), ""


def parameter_texts(effect: NamedEffect) -> list[str]:
    """Each parameter of an effect with its interval and unit; of a set, those of its first."""
    head = f"as {words(effect.name)}: " if effect.indistinguishable_from else ""
    texts = [
        f"{name} = {interval(one.value, one.low, one.high, one.unit)}"
        for name, one in effect.parameters.items()
    ]
    return [f"{head}{texts[0]}", *texts[1:]] if texts else []


def fit_lines(diagnosis: Findings, most: int | None = None) -> list[str]:
    """Return the before/after table as lines of at most 79 characters.

    Parameters
    ----------
    diagnosis : Findings
        With a line for each signal, and another for one that was also met without correction.
    most : int, optional
        Signals that are shown.
    """
    if not diagnosis.fit.signals:
        return []
    rows = [("error, unseen runs", COLUMNS)]
    for name, fit in list(diagnosis.fit.signals.items())[:most]:
        rows.append((words(name), _fit_cells(fit)))
        if fit.free_run is not None:
            rows.append((f"  {FREE_RUN}", _free_cells(fit.free_run)))
    wide = min(max(len(name) for name, _ in rows), 28)
    return [
        (name if len(name) <= wide else f"{name[: wide - 3]}...").ljust(wide)
        + "".join(cell.rjust(width) for cell, width in zip(cells, (10, 17, 11, 13), strict=True))
        for name, cells in rows
    ]


def summary_text(diagnosis: Findings) -> str:
    """Return the verdict sentence, the effects with numbers, cautions and the errors."""
    lines = [f"<Diagnosis: {diagnosis.verdict}> {verdict_sentence(diagnosis)}"]
    for effect in diagnosis.effects:
        lines.append(f"{claim_of_set(effect)}, probability {probability(effect.set_probability)}")
        lines += [f"  {text}" for text in parameter_texts(effect)]
    if misaligned := misaligned_sentence(diagnosis):
        lines.append(misaligned)
    return "\n".join([*lines, *beside_the_verdict(diagnosis), *fit_lines(diagnosis)])


def summary_html(diagnosis: Findings) -> str:
    """Return the same as a fragment of a page."""
    rows = "".join(
        f"<tr><td>{escape(claim_of_set(effect))}</td><td>{probability(effect.set_probability)}</td>"
        f"<td>{'<br>'.join(escape(text) for text in parameter_texts(effect))}</td></tr>"
        for effect in diagnosis.effects
    )
    heads = "<th>missing</th><th>probability</th><th>parameters</th>"
    told = (misaligned_sentence(diagnosis), *beside_the_verdict(diagnosis))
    cautions = "".join(f"<p>{escape(text)}</p>" for text in told if text)
    effects = f"<table><tr>{heads}</tr>{rows}</table>" if rows else ""
    verdict = f"<p><b>{escape(verdict_sentence(diagnosis))}</b></p>"
    return f"{verdict}{effects}{cautions}{_fit_html(diagnosis)}"


def _fit_html(diagnosis: Findings) -> str:
    if not diagnosis.fit.signals:
        return ""
    heads = "".join(f"<th>{name}</th>" for name in ("error, unseen recordings", *COLUMNS))
    rows = []
    for name, fit in diagnosis.fit.signals.items():
        rows.append(_row(words(name), _fit_cells(fit)))
        if fit.free_run is not None:
            rows.append(_row(f"{words(name)}, {FREE_RUN}", _free_cells(fit.free_run)))
    return f"<table><tr>{heads}</tr>{''.join(rows)}</table>"


def _row(name: str, cells: tuple[str, ...]) -> str:
    return f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in (name, *cells))}</tr>"
