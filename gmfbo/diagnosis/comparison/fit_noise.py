"""The noise about a fit: its levels, errors of the simulation beside it, and whitening by both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.hearing.sensed_noise import UnheardNoise
from gmfbo.diagnosis.comparison.inadequacy import inadequacy_columns
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.noise.high_band import estimated
from gmfbo.diagnosis.comparison.noise.places import Levels, blocks_of
from gmfbo.diagnosis.comparison.noise.whole_band import inadequate
from gmfbo.diagnosis.comparison.own_parts import own_spreads
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.row_fits import (
    beyond_noise,
    is_more_than_noise,
    log_likelihood,
    values_in,
)
from gmfbo.diagnosis.comparison.simulation_errors import SimulationErrors, errors_of
from gmfbo.diagnosis.comparison.whitener import UNMASKED, Whitening, segment_whitener

_LEAST_ROWS = 20  # of a segment, that tell levels over the whole band


@dataclass(frozen=True, eq=False)
class FitNoise:
    """What is needed to tell the noise about a fit.

    Attributes
    ----------
    problem : Problem
        Recordings and simulators.
    least : Levels
        Below which no level is looked for.
    cared : mapping of str to float
        [FMU's unit] By port, the level of an inadequacy below which nobody cares.
    held : float
        [FMU's unit] Torque that friction may hold at rest.
    """

    problem: Problem
    least: Levels
    cared: Mapping[str, float]
    held: float

    def levels(
        self, fitted: Fitted, kernels: PortKernels, near: Levels | None, errors: SimulationErrors
    ) -> Levels:
        """Levels of noise and inadequacy about a fit, beside errors of the simulation.

        Parameters
        ----------
        fitted : Fitted
            Whose residual is read.
        kernels : PortKernels
            Paths of noise.
        near : Levels, optional
            Where the search begins; without it those of the whole residual.
        errors : SimulationErrors
            What they most likely made of the residual is taken out of it first.
        """
        about = near
        if about is None:
            noise = self._of_noise(fitted, kernels, None)
            about = self._with_inadequacy(fitted, kernels, noise, noise)
        left = errors.taken_out(self.problem, fitted, kernels, about)
        noise = self._of_noise(left, kernels, near)
        return self._with_inadequacy(left, kernels, noise, about, near)

    def with_inadequacy(self, fitted: Fitted, ledger: Ledger) -> Levels:
        """A ledger's levels of noise, with those of the inadequacy that a fit leaves."""
        left = ledger.errors.taken_out(self.problem, fitted, ledger.kernels, ledger.levels)
        levels = ledger.levels
        return self._with_inadequacy(left, ledger.kernels, levels, levels, levels)

    def _of_noise(self, fitted: Fitted, kernels: PortKernels, near: Levels | None) -> Levels:
        problem = self.problem
        rates = problem.rates(fitted.values)
        free = [f"port:{p}" for p in self.least.ports]
        free += [f"own:{name}" for name in self.least.own]
        if any(r.any() for r in rates):
            free.append("jitter")
        blocks = blocks_of(problem.segments, fitted.residual, rates, kernels)
        return estimated(kernels, blocks, self._least(kernels), free, near)

    def _least(self, kernels: PortKernels) -> Levels:
        """Levels below which none is looked for, with the rounding of an encoder in the twin.

        Where it goes to the next count depends on less than anybody knows of an axis: a run of
        the same axis rounds otherwise, and the controller answers. Of slow motion it rounds rows
        alike, and high frequencies, by which levels are read, show little of that.
        """
        ports = {p: max(level, kernels.rounding) for p, level in self.least.ports.items()}
        return replace(self.least, ports=ports)

    def _with_inadequacy(
        self,
        fitted: Fitted,
        kernels: PortKernels,
        levels: Levels,
        about: Levels,
        near: Levels | None = None,
    ) -> Levels:
        problem = self.problem
        rates = problem.rates(fitted.values)
        least = {**self.cared, "sensor": self._least(kernels).ports.get("sensor", 0.0)}
        by = replace(about, jitter=0.0)
        parts = [
            (segment, residual, rate)
            for segment, residual, rate in zip(
                problem.segments, fitted.residual, rates, strict=True
            )
            if rate[:, UNMASKED].shape[1] >= _LEAST_ROWS
        ]
        if not parts:
            return levels
        white = [
            segment_whitener(segment, kernels, by, np.zeros_like(rate))(residual)[:, UNMASKED]
            for segment, residual, rate in parts
        ]
        segments, rates = [one[0] for one in parts], [one[2][:, UNMASKED] for one in parts]
        return inadequate(kernels, segments, white, rates, levels, least, near, by)

    def errors(
        self, fitted: Fitted, kernels: PortKernels, levels: Levels | None
    ) -> SimulationErrors:
        """Errors of the simulation about a fit, with those of noise that is played.

        Parameters
        ----------
        fitted : Fitted
            Where they are measured.
        kernels : PortKernels
            Paths of noise.
        levels : Levels, optional
            Of the noise that the controller reads; without it none is played.
        """
        problem, heard = self.problem, fitted.heard
        point = problem.point(fitted.hypothesis, fitted.x, fitted.own_values)
        level = 0.0 if levels is None else levels.ports.get("sensor", 0.0)
        unheard = None
        if heard is not None and levels is not None:
            point = replace(point, noise=heard.played)
            unheard = UnheardNoise(problem, fitted, kernels, levels).drawn
        found = errors_of(problem.simulations, point, kernels, level, self.held, unheard)
        return replace(found, dither=self._beyond_rounding(level))

    def _beyond_rounding(self, level: float) -> float:
        """White noise of a reading, in standard deviations of what rounding makes at least."""
        least = self.least.ports.get("sensor", 0.0)
        return float(np.sqrt(max((level / least) ** 2 - 1.0, 0.0))) if least else 0.0

    def likelier(
        self,
        fitted: Fitted,
        kernels: PortKernels,
        known: Sequence[Levels],
        errors: SimulationErrors,
    ) -> tuple[Levels, SimulationErrors]:
        """The likeliest of some levels, where errors of an input between its rows are beside them.

        Levels are read of what is left without the most likely of these errors, and some noise goes
        with it. The errors are left out where that is likelier: a straight line may be right, and
        noise of a logged current is in no motor.

        Parameters
        ----------
        fitted, kernels
            As of `whitening`.
        known : sequence of Levels
            Found beside these errors or others; the first ones where there are no such errors.
        errors : SimulationErrors
            With all of them.
        """
        if not errors.between:
            return known[0], errors
        bare = replace(errors, between=())
        tried = [(levels, errors) for levels in known]
        tried += [(self.levels(fitted, kernels, known[0], one), one) for one in (errors, bare)]
        found = [log_likelihood(fitted, self.scaled(fitted, kernels, *one)) for one in tried]
        return tried[int(np.argmax(found))]

    def with_own_parts(
        self, fitted: Fitted, kernels: PortKernels, levels: Levels, errors: SimulationErrors
    ) -> SimulationErrors:
        """The same errors with own parts of a fit's quantities in each recording."""
        whitening = self.whitening(fitted, kernels, levels, replace(errors, spreads={}))
        return replace(errors, spreads=own_spreads(self.problem, whitening, fitted))

    def whitening(
        self,
        fitted: Fitted,
        kernels: PortKernels,
        levels: Levels,
        errors: SimulationErrors,
        inadequacy: float = 0.0,
    ) -> Whitening:
        """Whitening by levels, errors of the simulation and a smooth inadequacy of a size."""
        problem, made = self.problem, []
        curves = inadequacy_columns(problem, kernels, fitted) if inadequacy else None
        parts = zip(
            problem.segments,
            problem.rates(fitted.values),
            errors.on(problem, fitted),
            problem.stretches(),
            strict=True,
        )
        for i, (segment, rate, (constant, varying), stretches) in enumerate(parts):
            if curves is not None:
                varying = np.concatenate([varying, inadequacy * curves[i]])
            whitener = segment_whitener(segment, kernels, levels, rate)
            whole = [slice(0, rate.shape[1])]
            made.append(whitener.beside(constant, whole).beside(varying, stretches))
        return Whitening(tuple(made), errors.spreads)

    def scaled(
        self, fitted: Fitted, kernels: PortKernels, levels: Levels, errors: SimulationErrors
    ) -> Whitening:
        """Whitening by noise that is larger in stretches in which a fit leaves more."""
        whitening = self.whitening(fitted, kernels, levels, errors)
        white = fitted.beside_own_parts(whitening)(fitted.residual)
        return whitening.scaled_to(white, self.problem.stretches())

    def alone(self, row: Fitted, ledger: Ledger) -> Ledger:
        """A ledger of one row, under the inadequacy that it leaves itself.

        Parameters
        ----------
        row : Fitted
            Any fit under the ledger's noise.
        ledger : Ledger
            With its levels of noise.
        """
        errors = self.with_own_parts(row, ledger.kernels, ledger.levels, ledger.errors)
        levels = self.with_inadequacy(row, replace(ledger, errors=errors))
        whitening = self.scaled(row, ledger.kernels, levels, errors)
        rows = {row.elements: row}
        return replace(ledger, rows=rows, levels=levels, whitening=whitening, errors=errors)

    def cared_about(self, fitted: Fitted, ledger: Ledger) -> Whitening:
        """Whitening by a ledger's noise, and the least inadequacy that anybody cares about."""
        levels = ledger.levels.with_missing(**self.cared)
        return self.whitening(fitted, ledger.kernels, levels, ledger.errors)

    def quiet(self, fitted: Fitted, ledger: Ledger) -> Whitening:
        """Whitening by a ledger's noise alone, without any inadequacy."""
        nothing = dict.fromkeys(set(ledger.levels.ports) - {"sensor"}, 0.0)
        levels = ledger.levels.with_missing(**nothing)
        return self.whitening(fitted, ledger.kernels, levels, ledger.errors)

    def share(self, base: Fitted, row: Fitted, ledger: Ledger) -> float | None:
        """Of the square that the refitted twin leaves beyond noise, what a row explains.

        None where it leaves no more than noise.

        Parameters
        ----------
        base, row : Fitted
            The refitted twin, and a row.
        ledger : Ledger
            With the noise.
        """
        whitening = self.quiet(base, ledger)
        beyond = beyond_noise(base, whitening)
        if not is_more_than_noise(beyond, values_in(base)):
            return None
        return 1.0 - beyond_noise(row, whitening) / beyond
