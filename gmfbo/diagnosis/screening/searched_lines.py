"""Lines and pulses that a search found in the misfit, as starts of the effects that need one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.runs.measured_excitation import demands, states_of
from gmfbo.diagnosis.screening.port_response import PortResponse, measure_port_response
from gmfbo.diagnosis.screening.pulses import EVERY, Pulse
from gmfbo.diagnosis.screening.repeating_and_passing import find_lines
from gmfbo.diagnosis.screening.testable_effects import candidates
from gmfbo.physics import CATALOGUE, Excitation


class SearchedLines:
    """What the searches of one diagnosis found last.

    Parameters
    ----------
    case : Case
        Twin and recordings; its setting learns the lines.
    rng : numpy Generator
        Of the excitation at the torque port.

    Attributes
    ----------
    response : PortResponse or None
        Answer of the outputs to a torque; None before a search, or without a torque port.
    """

    def __init__(self, case: Case, rng: np.random.Generator) -> None:
        self.case, self.rng = case, rng
        self.response: PortResponse | None = None
        self._pulses: tuple[Pulse, ...] = ()

    def look(self, progress: Callable[[str, float], None]) -> None:
        """Let what repeats in the misfit say which lines to test, and the motion which limits.

        Parameters
        ----------
        progress : callable (str, float)
            Told the stage and the share that is done.
        """
        case = self.case
        runs = zip(case.base.simulated, case.simulations.records, strict=True)
        met = demands(*(states_of(run, record) for run, record in runs))
        excitation = replace(case.setting.excitation, demands=met)
        case.change_setting(replace(case.setting, excitation=excitation))
        if "torque" not in case.base.simulated[0].response.ports:
            return
        progress("searching for lines", 0.1)
        self.response = response = measure_port_response(case, "torque", self.rng)
        if response is None:
            return
        lines = find_lines(case, case.base, response)
        self._pulses = lines.passing
        excitation = lines.within(case.setting.excitation)
        case.change_setting(replace(case.setting, excitation=excitation))

    def beside(self, model: Fitted, testable: Sequence[str]) -> list[Candidate]:
        """Lines and pulses beside named effects, as starts of the effects that need one."""
        if self.response is None:
            return []
        lines = find_lines(self.case, model, self.response)
        self._pulses = lines.passing
        excitation = lines.within(self.case.setting.excitation)
        searched = [name for name in testable if CATALOGUE[name].is_searched]
        return candidates(searched, excitation) + self.passing(testable, excitation)

    def passing(
        self, testable: Sequence[str], excitation: Excitation | None = None
    ) -> list[Candidate]:
        """A disturbance that passed in one recording, as a candidate in that one alone.

        Parameters
        ----------
        testable : sequence of str
            Effects that the recordings can show.
        excitation : Excitation, optional
            Holds the lines; that of the case without it.
        """
        name = "pulse_disturbance"
        if name not in testable:
            return []
        return [
            Candidate(name, dict(start), only=pulse.record)
            for start, pulse in zip(
                CATALOGUE[name].starts(excitation or self.case.setting.excitation),
                self._pulses,
                strict=False,
            )
            if pulse.record != EVERY
        ]
