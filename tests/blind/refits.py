"""Baselines that refit the twin: a Gaussian process on what is left, and stepwise fits.

Both get the package's own alignment, noise model and simulators: what they lack is the decision.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from gmfbo import FmuTwin, Recording
from gmfbo.diagnosis.case.case import Case, dof
from gmfbo.diagnosis.case.open_case import open_case, open_unseen
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.screening.testable_effects import candidates, untestable
from gmfbo.physics import CATALOGUE
from tests.blind.truth import SAMPLE

Vector = NDArray[np.float64]

_POINTS = 300
_SCALES = (0.3, 1.0, 3.0)
_NOISES = (0.03, 0.1, 0.3, 1.0)
_MOST_LAWS = 4
_FITTED = 5
_ITERATIONS = 10


@dataclass(frozen=True)
class Errors:
    """RMS errors of one signal on the recording held out, over its range.

    Attributes
    ----------
    parameters_only : float
        Of the refitted twin.
    augmented : float
        Of the method's model.
    noise_floor : float
        Of a perfect one.
    """

    parameters_only: float
    augmented: float
    noise_floor: float


class Refits:
    """A case opened on its training recordings and on one that is held out.

    Parameters
    ----------
    folder : Path
        Of the case.
    held_out : str
        Name of the recording that is kept for the end.
    """

    def __init__(self, folder: Path, held_out: str) -> None:
        self._twin = FmuTwin(folder / "twin.toml")
        files = sorted(folder.glob("rec*.csv"))
        read = {path.name: Recording.read(path, self._twin) for path in files}
        unseen = read.pop(held_out)
        self._runs = 0
        self.case: Case = open_case(
            self._twin, list(read.values()), seed=0, jobs=1, on_run=self._count
        )
        self.unseen = open_unseen(self.case, [unseen], seed=0, jobs=1)

    def __enter__(self) -> Refits:
        return self

    def __exit__(self, *error: object) -> None:
        self.case.simulations.close()
        self.unseen.simulations.close()
        self._twin.close()

    def _count(self) -> None:
        self._runs += 1

    @property
    def simulations(self) -> int:
        """Runs of the twin on training recordings."""
        return self._runs

    def gp_ratio(self) -> float:
        """Held-out error with a process on the residuals, over that without one.

        Geometric mean over the signals. The process sees position, velocity and acceleration.
        """
        ratios = [
            one.augmented / max(one.parameters_only, 1e-300) for one in self.process().values()
        ]
        return float(np.exp(np.mean(np.log(ratios))))

    def process(self) -> dict[str, Errors]:
        """Held-out errors with a Gaussian process on the residuals, by signal."""
        seen = [_states(record) for record in self.case.simulations.records]
        new = _states(self.unseen.simulations.records[0])
        mean, size = np.mean(np.vstack(seen), axis=0), np.std(np.vstack(seen), axis=0) + 1e-12
        rows = [_thinned(len(x)) for x in seen]
        x = np.vstack([(s[k] - mean) / size for s, k in zip(seen, rows, strict=True)])
        pick = np.linspace(0, len(x) - 1, min(_POINTS, len(x))).astype(int)
        known, left = _residuals(self.case), []
        for i, target in enumerate(_residuals(self.unseen)[0]):
            y = np.concatenate([own[i][k] for own, k in zip(known, rows, strict=True)])
            left.append(target - _predicted(x[pick], y[pick], (new - mean) / size))
        return self._errors(left)

    def stepwise(self) -> tuple[tuple[str, ...], dict[str, Errors]]:
        """Laws that are added one by one while BIC falls (Schwarz 1978), and held-out errors.

        Each step takes one Gauss-Newton step with every law that can be tested beside those that
        are there, fits the `_FITTED` best of these to the end, and keeps the best.
        """
        best = self.case.base.measured_by(self.case.plain)
        bic = self._seen_bic(best)
        testable = [name for name in CATALOGUE if name not in self._reasons]
        while len(best.hypothesis.effects) < _MOST_LAWS:
            there = {one.effect for one in best.hypothesis.effects}
            tried = [
                self._beside(best, candidate, iterations=1)
                for candidate in candidates(testable, self.case.setting.excitation)
                if candidate.effect not in there
            ]
            ranked = sorted(filter(None, tried), key=self._seen_bic)[:_FITTED]
            fits = [self._beside(best, one.hypothesis.effects[-1]) for one in ranked]
            found = min(filter(None, fits), key=self._seen_bic, default=None)
            if found is None or self._seen_bic(found) >= bic:
                break
            best, bic = found, self._seen_bic(found)
        run = self.unseen.simulations.run_here(best.hypothesis.point(best.x))[0]
        signals = self.unseen.simulations.records[0].signals
        if run.finite:
            left = [np.nan_to_num(s.values - v) for s, v in zip(signals, run.signals, strict=True)]
        else:
            left = _residuals(self.unseen)[0]
        return tuple(one.effect for one in best.hypothesis.effects), self._errors(left)

    def _beside(
        self, best: Fitted, candidate: Candidate, iterations: int = _ITERATIONS
    ) -> Fitted | None:
        hypothesis = Hypothesis(self.case.setting, (*best.hypothesis.effects, candidate))
        # By the same measure as the parameters alone: an inadequate base widens `case.misfit`.
        return fit(self.case.plain, hypothesis, best.parameters, near=best, iterations=iterations)

    def _errors(self, left: Sequence[Vector]) -> dict[str, Errors]:
        """Of the refitted twin and of a model that leaves these residuals, over the range."""
        found, signals = {}, self.unseen.simulations.records[0].signals
        for signal, before, after in zip(signals, _residuals(self.unseen)[0], left, strict=True):
            extent = float(np.ptp(signal.values)) or 1.0
            found[signal.name] = Errors(
                _rms(before) / extent,
                _rms(after) / extent,
                self.case.noise[signal.name].total / extent,
            )
        return found

    def _seen_bic(self, fitted: Fitted) -> float:
        return float(fitted.chi2 + len(fitted.x) * np.log(dof(self.case.plain)))

    @property
    def _reasons(self) -> dict[str, str]:
        """Why laws cannot be tested."""
        return untestable(
            self._twin.file,
            self.case.setting.excitation,
            has_inertia=self.case.setting.inertia is not None,
            is_open=self.case.simulations.tracking is not None,
        )


def _residuals(case: Case) -> list[list[Vector]]:
    """Recorded minus simulated [SI], by recording and signal."""
    return [
        [
            np.nan_to_num(signal.values - values)
            for signal, values in zip(record.signals, run.signals, strict=True)
        ]
        for record, run in zip(case.simulations.records, case.base.simulated, strict=True)
    ]


def _states(record: object) -> Vector:
    """Position, velocity and acceleration of a recording, shape (rows, 3)."""
    signals = {signal.name: signal.values for signal in record.signals}  # type: ignore[attr-defined]
    q = signals["position"]
    kernel = np.hanning(21) / np.hanning(21).sum()
    smooth = np.convolve(np.pad(q, 10, mode="edge"), kernel, mode="valid")
    v = np.gradient(smooth, SAMPLE)
    return np.column_stack([smooth, v, np.gradient(v, SAMPLE)])


def _thinned(rows: int) -> NDArray[np.int64]:
    return np.arange(0, rows, max(1, rows // _POINTS))


def _predicted(x: Vector, y: Vector, new: Vector) -> Vector:
    """Mean of a Gaussian process; length and noise by the likelihood over a small grid."""
    spread = float(np.std(y)) or 1.0
    z = (y - np.mean(y)) / spread
    best, kept = np.inf, (1.0, 1.0)
    square = _squares(x, x)
    for scale in _SCALES:
        for noise in _NOISES:
            factor = cho_factor(np.exp(-0.5 * square / scale**2) + noise**2 * np.eye(len(z)))
            loss = float(z @ cho_solve(factor, z) + 2.0 * np.sum(np.log(np.diag(factor[0]))))
            if loss < best:
                best, kept = loss, (scale, noise)
    scale, noise = kept
    factor = cho_factor(np.exp(-0.5 * square / scale**2) + noise**2 * np.eye(len(z)))
    across = np.exp(-0.5 * _squares(new, x) / scale**2)
    return np.asarray(np.mean(y) + spread * across @ cho_solve(factor, z))


def _squares(a: Vector, b: Vector) -> Vector:
    return np.asarray(np.sum((a[:, None, :] - b[None, :, :]) ** 2, axis=2))


def _rms(values: Vector | Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
