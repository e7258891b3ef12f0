"""How much a hidden effect could gain over parameters alone, for one who knows the truth.

gain = min over what the twin knows only roughly (inertia and viscous friction) of
       sum over recordings and frequencies to 200 Hz of e^H S^-1 e

where e is the difference between the truth and the truth without its effect under the same noise,
in reading and command, as the mean over a few runs, and S(f) the spectrum of both, 2 x 2, of what
is no physics:

- the noise of the encoder as the loop carries it to both signals, from repeated runs, and that
  of the command's column;
- (0.5 %)^2 of each signal's own spectrum, smoothed over an octave;
- what loggers and current loops are known to do, as `NUISANCES`: a lag and a shift of 0.1 ms, a
  clock 100 ppm off, 2 % (or what the twin file declares) in the scale of the command's column.
  The stressed nulls hold such errors, and there they must not be called physics. Where inertia
  and viscous friction are no free parameters, 2 % in the gain of the drive too.

For noise of this spectrum the gain is the expected drop of chi2 by the true effect. Noise belongs
to the plant in a loop: it dithers friction, gaps and dead zones away, and drives a command into a
limit that it would not reach without. The logger's convention counts as known. A twin in open loop
knows nothing of the loop that made its recordings: it runs on the command that was recorded, noise
included, from where the recording starts, and its reading alone is compared. Noise of the command
drifts without end there, so that the frequencies of a taper's transform are no longer independent,
and a constant push would be worth a hundred times what can be told from noise. What is slower than
`FORGETS` is therefore taken off first, from differences, noise and signals alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import bilinear, lfilter
from scipy.signal.windows import tukey

from tests.blind.machines import Machine
from tests.blind.truth import KINDS, PREROLL, SAMPLE, TrueRun, Vector, simulate

Complex = NDArray[np.complexfloating]

HIGHEST = 200.0
"""[Hz] Above, nothing is compared."""

TOLERANCE = 0.005
"""Share of a signal below which a difference is no physics."""

NUISANCES = {"lag": 1e-4, "shift": 1e-4, "skew": 1e-4, "scale": 0.02, "drive": 0.02}
"""[s, s, 1, 1, 1] Standard deviations of errors that are no physics."""

FORGETS = 10.0
"""[rad/s] Below which a plant in open loop is not compared: two poles there."""

REALISATIONS = 4
NEIGHBOURS = 4
_BOUNDS = np.log(3.0)


@dataclass(frozen=True)
class Experiment:
    """One recording that is asked of a machine: its reference, and the gains in force."""

    shape: str
    reference: Vector
    gains: Mapping[str, float]


@dataclass(frozen=True)
class Oracle:
    """Judges hidden effects on one set of experiments.

    Attributes
    ----------
    machine : Machine
        For its noise.
    values : mapping of str to float
        True parameters without effects.
    experiments : sequence of Experiment
        All recordings.
    seed : int
        Of the noise that shapes S.
    uncertain_scale : float
        Of the command's column, as the twin file declares it; 0 where it does not.
    """

    machine: Machine
    values: Mapping[str, float]
    experiments: Sequence[Experiment]
    seed: int
    uncertain_scale: float = 0.0

    def runs(self, changes: Mapping[str, float]) -> list[TrueRun]:
        """Noise-free runs of the truth with some parameters changed."""
        return [
            simulate({**self.values, **one.gains, **changes}, one.reference)
            for one in self.experiments
        ]

    @cached_property
    def clean(self) -> list[TrueRun]:
        """Noise-free runs without any effect."""
        return self.runs({})

    def means(self, changes: Mapping[str, float]) -> list[Vector]:
        """Reading and command of the same runs, as the mean under each noise of `_noises`."""
        if self.machine.is_open_loop:
            return [_signals(run) for run in self.runs(changes)]
        return [
            np.mean(
                [
                    _signals(simulate({**self.values, **one.gains, **changes}, one.reference, n))
                    for n in noises
                ],
                axis=0,
            )
            for one, noises in zip(self.experiments, self._noises, strict=True)
        ]

    @property
    def _jitter(self) -> float:
        """[position] Standard deviation of the encoder's noise and of its counts."""
        return float(np.hypot(self.machine.jitter, self.machine.quantum / np.sqrt(12.0)))

    @cached_property
    def _noises(self) -> list[list[Vector]]:
        """Of the encoder, a few for each experiment, each of shape (PREROLL + rows,) [position]."""
        rng = np.random.default_rng([self.seed, 1])
        return [
            [
                self._jitter * rng.standard_normal(PREROLL + len(one.reference))
                for _ in range(REALISATIONS)
            ]
            for one in self.experiments
        ]

    @cached_property
    def _whitening(self) -> list[Complex]:
        """Inverse Cholesky factors of S, shape (frequencies, 2, 2) for each experiment."""
        rng = np.random.default_rng(self.seed)
        factors = []
        for one, clean in zip(self.experiments, self.clean, strict=True):
            values, rows = {**self.values, **one.gains}, len(one.reference)
            spectra = []
            signals = _signals(clean)
            for _ in range(REALISATIONS):
                noise = self._jitter * rng.standard_normal(PREROLL + rows)
                if self.machine.is_open_loop:
                    drive = self.machine.command_noise * rng.standard_normal(rows)
                    noisy = _driven(values, signals + np.outer(drive, [0.0, 1.0]))
                    noisy[:, 0] += noise[PREROLL:]
                    noisy[:, 1] = signals[:, 1]
                    spectra.append(_spectrum(self.compared(noisy - _driven(values, signals))))
                else:
                    spectra.append(
                        _spectrum(_signals(simulate(values, one.reference, noise)) - signals)
                    )
            n = np.array(spectra)
            s = _smoothed(np.einsum("rfi,rfj->fij", n, n.conj()) / REALISATIONS, self._steep(rows))
            s[:, 1, 1] += self.machine.command_noise**2 * np.sum(_window(rows) ** 2)
            start = signals[0] if self.machine.is_open_loop else 0.0
            own = np.abs(_spectrum(self.compared(signals - start))) ** 2
            for signal in range(2):
                s[:, signal, signal] += TOLERANCE**2 * _over_an_octave(own[:, signal])
            factors.append(np.linalg.inv(np.linalg.cholesky(s)))
        return factors

    def compared(self, signals: Vector) -> Vector:
        """Of a plant in open loop what is faster than it drifts, shape (rows, n); else all.

        The zeros are the plant's own poles: a constant push stays a constant.
        """
        if not self.machine.is_open_loop:
            return signals
        own = [1.0, self.values["viscous"] / self.values["inertia"], 0.0]
        b, a = bilinear(own, [1.0, 2.0 * FORGETS, FORGETS**2], fs=1.0 / SAMPLE)
        return np.asarray(lfilter(b, a, signals, axis=0))

    def _steep(self, rows: int) -> Vector:
        """Frequencies to the fourth where a command's noise moves a free axis, from `FORGETS`."""
        kept = int(HIGHEST * rows * SAMPLE) + 1
        frequency = np.arange(kept) / (rows * SAMPLE)
        own = np.maximum(2.0 * np.pi * frequency / FORGETS, 1.0) ** 4
        return (own if self.machine.is_open_loop else np.ones(kept))[:, None, None]

    def _white(self, differences: Sequence[Vector]) -> Vector:
        """Whitened differences of all experiments, as one real vector."""
        parts = []
        for e, factor in zip(differences, self._whitening, strict=True):
            w = np.einsum("fij,fj->fi", factor, _spectrum(e)) * np.sqrt(2.0)
            w[0] /= np.sqrt(2.0)  # the mean is real: one number where others are two
            parts += [w.real.ravel(), w.imag.ravel()]
        return np.concatenate(parts)

    @cached_property
    def _nuisances(self) -> tuple[Vector, Vector]:
        """Directions (orthonormal columns) of the nuisances, and what they leave of each."""
        scale = self.uncertain_scale or NUISANCES["scale"]
        lag = self.values.get("torque_lag", 0.0) + NUISANCES["lag"]
        clean = [_signals(run) for run in self.clean]
        shown = np.array([1.0, 0.0 if self.machine.is_open_loop else 1.0])
        slopes = [np.gradient(one, SAMPLE, axis=0) * shown for one in clean]
        ages = [np.arange(len(one))[:, None] * SAMPLE for one in clean]
        moved = [t * v for t, v in zip(ages, slopes, strict=True)]
        columns = [
            self._white(self._unlike(self.means({"torque_lag": lag}))),
            NUISANCES["shift"] * self._white([self.compared(v) for v in slopes]),
            NUISANCES["skew"] * self._white([self.compared(v) for v in moved]),
        ]
        if self.machine.is_open_loop:
            louder = [one * np.array([1.0, 1.0 + scale]) for one in clean]
            columns.append(self._white(self._unlike(louder)))
        else:
            columns.append(scale * self._white([one * np.array([0.0, 1.0]) for one in clean]))
        if self.machine.is_measured:
            step = 0.1 * NUISANCES["drive"]
            stronger = self._unlike(self.means({"drive_gain_error": step}))
            columns.append(NUISANCES["drive"] / step * self._white(stronger))
        u, size, _ = np.linalg.svd(np.array(columns).T, full_matrices=False)
        return u, 1.0 / np.sqrt(1.0 + size**2)

    def _residual(self, differences: Sequence[Vector]) -> Vector:
        """Whitened differences with the nuisances' directions made light."""
        white = self._white(differences)
        u, left = self._nuisances
        along = u.T @ white
        return np.asarray(white - u @ ((1.0 - left) * along))

    def _unlike(
        self, true: Sequence[Vector], changes: Mapping[str, float] | None = None
    ) -> list[Vector]:
        """What happened less what a twin with some parameters changed shows of it."""
        if not self.machine.is_open_loop:
            model = self._nominal if changes is None else self.means(changes)
            return [a - b for a, b in zip(true, model, strict=True)]
        return [
            self.compared(a - _driven({**self.values, **one.gains, **(changes or {})}, a))
            for a, one in zip(true, self.experiments, strict=True)
        ]

    def difference(self, true: Sequence[Vector], changes: Mapping[str, float]) -> Vector:
        """Whitened difference of the truth and a plant with these changes, nuisances made light.

        Parameters
        ----------
        true : sequence of ndarray
            Means of the truth.
        changes : mapping of str to float
            Of the other plant.
        """
        return self._residual(self._unlike(true, changes))

    @cached_property
    def _nominal(self) -> list[Vector]:
        return self.means({})

    @cached_property
    def _sensitivities(self) -> Vector:
        """Orthonormal basis of what the parameters can do, about the true ones."""
        columns = [
            self.difference(self._nominal, {name: 1.002 * self.values[name]})
            for name in self.machine.free
        ]
        rows = sum(2 * f.shape[0] * 2 for f in self._whitening)
        return np.linalg.qr(np.array(columns).reshape(-1, rows).T)[0]

    def quick_gain(self, true: Sequence[Vector]) -> float:
        """Gain of true means with the parameters' influence taken as linear: to choose a size."""
        e = self._residual(self._unlike(true))
        basis = self._sensitivities
        return float(e @ e - np.sum((basis.T @ e) ** 2))

    def gain(
        self,
        changes: Mapping[str, float],
        known: Mapping[str, float] | None = None,
        means: Sequence[Vector] | None = None,
    ) -> float:
        """Gain of the true plant's changes over parameters alone.

        Parameters
        ----------
        changes : mapping of str to float
            Truth parameters of all hidden effects.
        known : mapping of str to float, optional
            Those of the effects that the model has already.
        means : sequence of ndarray, optional
            The plant's, where they have been made.
        """
        true = self.means(changes) if means is None else means
        free, known = self.machine.free, dict(known or {})

        def residual(p: Vector) -> Vector:
            refitted = {
                name: known.get(name, self.values[name]) * float(np.exp(step))
                for name, step in zip(free, p, strict=True)
            }
            return self.difference(true, {**known, **refitted})

        return self._least(residual, len(free))[0]

    def gain_over(
        self,
        true: Sequence[Vector],
        model: Callable[[Vector], Mapping[str, float]],
        count: int,
    ) -> tuple[float, Vector]:
        """Gain of the truth over another model of the plant, refitted, and where that is.

        Parameters
        ----------
        true : sequence of ndarray
            Means of the truth.
        model : callable
            Changes of the plant for logarithms of factors of its free values, at first all zero.
        count : int
            How many are free.
        """
        return self._least(lambda p: self.difference(true, model(p)), count)

    @staticmethod
    def _least(residual: Callable[[Vector], Vector], count: int) -> tuple[float, Vector]:
        """Sum of squares after a fit from zero on, and its place."""
        if not count:
            return float(np.sum(residual(np.zeros(0)) ** 2)), np.zeros(0)
        fit = least_squares(
            residual,
            np.zeros(count),
            bounds=(-_BOUNDS, _BOUNDS),
            diff_step=np.full(count, 2e-3),
            x_scale=np.full(count, 0.1),
            ftol=1e-2,
            xtol=1e-3,
            max_nfev=6,
        )
        return float(2.0 * fit.cost), np.asarray(fit.x)


def _driven(values: Mapping[str, float], signals: Vector) -> Vector:
    """Reading of the plant in open loop, under the command and from the place of two signals."""
    reading, held = signals.T
    command = np.append(held[1:], held[-1])  # what is held at a row was computed at the one before
    alone = {**values, "kind": KINDS["none"], "start": float(reading[0])}
    run = simulate(alone, command, preroll=0)
    return np.column_stack([run.reading, held])


def _signals(run: TrueRun) -> Vector:
    return np.column_stack([run.reading, run.held])


def _window(rows: int) -> Vector:
    return np.asarray(tukey(rows, 0.1))


def _spectrum(signals: Vector) -> Complex:
    """Tapered transform up to `HIGHEST`, shape (frequencies, 2)."""
    rows = len(signals)
    kept = int(HIGHEST * rows * SAMPLE) + 1
    return np.asarray(np.fft.rfft(signals * _window(rows)[:, None], axis=0)[:kept])


def _smoothed(s: Complex, steep: Vector) -> Complex:
    """Mean over neighbouring frequencies, of what is even where `steep` has been multiplied."""
    s = s * steep
    width = 2 * NEIGHBOURS + 1
    padded = np.pad(s, ((NEIGHBOURS, NEIGHBOURS), (0, 0), (0, 0)), mode="symmetric")
    total = np.cumsum(np.concatenate([np.zeros((1, 2, 2)), padded]), axis=0)
    return np.asarray((total[width:] - total[:-width]) / width / steep)


def _over_an_octave(power: Vector) -> Vector:
    """Mean of a spectrum over the octave around each frequency."""
    index = np.arange(len(power))
    low = np.floor(index / np.sqrt(2.0)).astype(int)
    high = np.minimum(np.ceil(index * np.sqrt(2.0)).astype(int) + 1, len(power))
    high = np.maximum(high, low + 2)
    total = np.concatenate([[0.0], np.cumsum(power)])
    high = np.minimum(high, len(power))
    return np.asarray((total[high] - total[low]) / (high - low))
