"""Corrected twin runs (IS3): the twin around a real run, corrected by that run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.store.trial import Trial
from gmfbo.sources.plants.source import Source
from gmfbo.tuning.history.history import History
from gmfbo.tuning.query.initial_design import Stream, stream
from gmfbo.tuning.query.method import CorrectionOptions
from gmfbo.tuning.study.playing import play

if TYPE_CHECKING:
    from gmfbo.correction.local_samples import LocalSample
    from gmfbo.correction.trajectory_gp import Pair, TrajectoryCorrection


@dataclass(frozen=True, eq=False)
class CorrectedRuns:
    """Makes corrected runs around a real one.

    Attributes
    ----------
    source : Source
        The twin.
    history : History
        Holds the real runs and the twin's runs at their gains; corrected runs are added.
    options : CorrectionOptions
        Options of the method.
    """

    source: Source
    history: History
    options: CorrectionOptions

    def around(self, real: Trial) -> Iterator[Trial]:
        """Draw and correct around a real run; yields each draw once it is on disk.

        All draws follow from the seed and the real run. So after a kill they are drawn again, and
        the missing ones are written.

        Parameters
        ----------
        real : Trial
            A real run, with the twin's run beside it in the history.
        """
        from gmfbo.correction.local_samples import SamplingSettings, draw_local_samples

        history, options = self.history, self.options
        settings = SamplingSettings(
            count=history.study.budget.is3_per_run, at_border=options.at_border
        )
        stored = history.children(real, "IS3")
        if sum(trial.accepted is True for trial in stored) == settings.count:
            return
        correction = self._fit(real)
        if correction is None:
            return
        runs: list[tuple[dict[str, float], Recording]] = []

        def simulate(
            point: NDArray[np.float64],
        ) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
            gains = history.gains_at(point)
            run = play(self.source, gains, history.experiment)
            runs.append((gains, run))
            if isinstance(run, Trajectory) and run.status != "ok":
                return None
            return run.time, run.signal(history.experiment.signal)

        samples = draw_local_samples(
            history.unit_point(real.gains),
            simulate,
            correction,
            history.experiment.reference_size,
            settings,
            stream(history.study.seed, Stream.IS3, real.number),
        )
        corrected = iter(samples.draws)
        for position, (gains, run) in enumerate(runs):
            failed = isinstance(run, Trajectory) and run.status != "ok"
            sample = None if failed else next(corrected)
            if position >= len(stored):
                yield history.write(self._trial(real, gains, run, sample))

    def _fit(self, real: Trial) -> TrajectoryCorrection | None:
        """Correction by this real run and, where the method asks for it, by earlier ones."""
        from gmfbo.correction.trajectory_gp import CorrectionSettings, TrajectoryCorrection

        latest = self._pair(real)
        if latest is None:
            return None
        earlier = [trial for trial in self.history.of("IS1") if trial.number < real.number]
        pairs = [pair for trial in earlier if (pair := self._pair(trial)) is not None]
        correction = TrajectoryCorrection.fit(
            [*pairs, latest], CorrectionSettings(memory=self.options.memory)
        )
        self.history.store.log(
            "correction",
            parent=real.number,
            held_out_error=correction.held_out_error,
            uncorrected_error=correction.uncorrected_error,
            note=correction.note,
        )
        return correction

    def _pair(self, real: Trial) -> Pair | None:
        """Signals of a real run and of the twin at its gains; None without a pair of them."""
        from gmfbo.correction.trajectory_gp import Pair

        beside = self.history.children(real, "IS2")
        if real.status != "ok" or real.bare or not beside or beside[0].status != "ok":
            return None
        signal, twin = self.history.experiment.signal, beside[0].recording
        time = real.recording.time
        common = (time >= twin.time[0]) & (time <= twin.time[-1])
        return Pair(
            time=time[common],
            simulated=np.interp(time[common], twin.time, twin.signal(signal)),
            measured=real.recording.signal(signal)[common],
            gains=self.history.unit_point(real.gains),
        )

    def _trial(
        self, real: Trial, gains: dict[str, float], run: Recording, sample: LocalSample | None
    ) -> Trial:
        signal, twin = self.history.experiment.signal, self.source.content_hash
        if sample is None:
            failed = self.history.trial("IS3", gains, run, twin=twin, parent=real.number)
            return replace(failed, accepted=False)
        corrected = _only(run, signal, sample.corrected)
        trial = self.history.trial("IS3", gains, corrected, twin=twin, parent=real.number)
        return replace(
            trial,
            sigma_c=sample.sigma_c,
            accepted=sample.accepted,
            uncorrected={signal: sample.simulated},
            std={signal: sample.std},
        )


def _only(run: Recording, signal: str, values: NDArray[np.float64]) -> Trajectory:
    """The run with its corrected signal alone, since the others are not corrected."""
    return Trajectory(
        time=run.time,
        signals={signal: values},
        units={signal: run.units[signal]} if signal in run.units else {},
        name=run.name,
        parameters=run.parameters,
        seconds=run.seconds if isinstance(run, Trajectory) else 0.0,
    )
