"""Result of a check of recordings, as values."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from gmfbo.diagnosis.result.findings import Cost
from gmfbo.diagnosis.result.named_effect import NotTestable

Basis = Literal["controller", "twin"]

CHECK_SCHEMA = 1


@dataclass(frozen=True)
class Finding:
    """A fault of a recording, and its cure.

    Attributes
    ----------
    kind : str
        Such as `repeated_samples`.
    recording : str
        Its name; empty where all are meant.
    signal : str
        Column; empty where all columns or the clock are meant.
    what : str
        Fault, with numbers.
    cure : str
        Cure of the fault.
    """

    kind: str
    recording: str
    signal: str
    what: str
    cure: str


@dataclass(frozen=True)
class ColumnQuality:
    """Quality of one signal's column in one recording.

    Attributes
    ----------
    unit : str
        SI unit.
    rows : int
        Samples.
    resolution : float
        [unit] Quantum of the values; 0 where they are continuous.
    steps : float
        Quanta within the range; infinite where the values are continuous.
    noise : float
        [unit] White noise, standard deviation.
    low, high : float
        [unit] Extreme values.
    repeated : int
        Rows that repeat the one before although the signal moves.
    refresh : float
        Rows for which a value stays the same on average; 1 where each row is a new sample.
    blank : int
        Rows without a value between the first and the last sample, beyond its own rate.
    clipped : float
        Share of the rows that stay at an extreme value which the signal ran into.
    limit : float or None
        [unit] Size that the twin does not let the signal exceed.
    limit_from : str
        Where that limit was found.
    at_limit : float
        Share of the rows within 1 % of that limit.
    """

    unit: str
    rows: int
    resolution: float
    steps: float
    noise: float
    low: float
    high: float
    repeated: int
    refresh: float
    blank: int
    clipped: float
    limit: float | None
    limit_from: str
    at_limit: float


@dataclass(frozen=True)
class ClockQuality:
    """Quality of a recording's clock.

    Attributes
    ----------
    step : float
        [s] Median time between rows.
    jitter : float
        Largest deviation of a step from that, as a share of it; lost rows do not count.
    lost_by_clock : int
        Rows that the times leave out.
    lost_at : tuple of float
        [s] Where all moving signals jump as if rows were lost, although the times do not show it.
    """

    step: float
    jitter: float
    lost_by_clock: int
    lost_at: tuple[float, ...]


@dataclass(frozen=True)
class SeenAlignment:
    """Shift, scale and offset of a column against its expected values, in one recording.

    Attributes
    ----------
    basis : {"controller", "twin"}
        Expected values: those that the controller computes from the recorded measurement, or the
        twin's, where changes that its parameters could make are left out.
    shift : float
        [s] Delay of the column.
    scale : float
        Recorded over expected.
    offset : float
        [SI] Recorded less expected.
    explained : float
        Share of the squared difference that shift, scale and offset remove.

    Notes
    -----
    A shift, scale or offset that these data cannot tell is NaN.
    """

    basis: Basis
    shift: float
    scale: float
    offset: float
    explained: float


@dataclass(frozen=True)
class RecordingFacts:
    """Motion, quality and alignment of one recording.

    Attributes
    ----------
    duration : float
        [s]
    bandwidth : float
        [Hz] Highest frequency at which the response to the reference is trusted; NaN if none.
    reversals : int
        Changes of direction after which the axis travels on.
    position, speed : tuple of float
        [FMU's units] Lowest and highest; of the speed the 0.5 and 99.5 % quantiles, of the twin
        where no velocity was recorded.
    clock : ClockQuality
        How evenly its rows were sampled.
    columns : mapping of str to ColumnQuality
        By signal that the twin reads or is compared with.
    alignment : mapping of str to SeenAlignment
        By signal that the twin is compared with.
    parity : float
        Mean square of the controller's residual, 1 where it is right; NaN where it was not seen.
    has_position : bool
        Whether a position was recorded; `position` is the twin's where not.
    """

    duration: float
    bandwidth: float
    reversals: int
    position: tuple[float, float]
    speed: tuple[float, float]
    clock: ClockQuality
    columns: Mapping[str, ColumnQuality]
    alignment: Mapping[str, SeenAlignment]
    parity: float
    has_position: bool = True

    def later_by(self, seconds: float) -> RecordingFacts:
        """Tell times by a clock that shows more.

        Parameters
        ----------
        seconds : float
            [s] What it shows more.
        """
        lost_at = tuple(time + seconds for time in self.clock.lost_at)
        return replace(self, clock=replace(self.clock, lost_at=lost_at))


@dataclass(frozen=True)
class ResponseSeen:
    """Empirical frequency response from the reference to a signal, over all recordings.

    Attributes
    ----------
    source, signal : str
        From which input to which output.
    frequency : tuple of float
        [Hz] Where the reference excites.
    gain, phase : tuple of float
        Recorded: [signal's unit / reference's unit] and [rad].
    twin_gain, twin_phase : tuple of float
        The same of the twin as it is, by the same estimator.
    coherence : tuple of float
        Of the recorded response, 0 to 1.
    trusted : tuple of float
        [Hz] Lowest and highest frequency at which the response is trusted; NaN where none.
    apart : float
        Largest `|recorded / twin - 1|` between them beyond noise; 0 where noise explains all.
    apart_at : float
        [Hz] Frequency of that; NaN where noise explains all.
    """

    source: str
    signal: str
    frequency: tuple[float, ...]
    gain: tuple[float, ...]
    phase: tuple[float, ...]
    twin_gain: tuple[float, ...]
    twin_phase: tuple[float, ...]
    coherence: tuple[float, ...]
    trusted: tuple[float, float]
    apart: float
    apart_at: float


@dataclass(frozen=True)
class Showable:
    """Smallest size at which an effect would have been named.

    Attributes
    ----------
    parameter, unit : str
        Parameter that is the size, and its unit.
    together : float
        [unit] In all recordings together.
    alone : mapping of str to float
        [unit] In each recording by itself; infinite where no size would show.
    floor : float
        [unit] Below which the effect is never claimed; no size is smaller.
    """

    parameter: str
    unit: str
    together: float
    alone: Mapping[str, float]
    floor: float


@dataclass(frozen=True)
class Check:
    """Faults of recordings, and the effects that they can show; found without a fit.

    Attributes
    ----------
    twin : str
        Its name.
    findings : tuple of Finding
        Faults, worst first.
    recordings : mapping of str to RecordingFacts
        By name.
    logged : mapping of str to str
        By signal that changes at a sampling instant: the logger stores the `held` or `new` value.
    parity_why_not : str
        Why the controller could not be checked; empty where it was.
    responses : tuple of ResponseSeen
        From the reference to each signal.
    showable : mapping of str to Showable
        By effect.
    not_testable : tuple of NotTestable
        Effects that these recordings cannot show, and why.
    notes : tuple of str
        Remarks.
    units : mapping of str to str
        `position` and `velocity`, as the FMU spells them.
    cost : Cost
        Simulations and time.
    """

    twin: str
    findings: tuple[Finding, ...]
    recordings: Mapping[str, RecordingFacts]
    logged: Mapping[str, str]
    parity_why_not: str
    responses: tuple[ResponseSeen, ...]
    showable: Mapping[str, Showable]
    not_testable: tuple[NotTestable, ...]
    notes: tuple[str, ...]
    units: Mapping[str, str]
    cost: Cost

    def to_json(self) -> str:
        """Return all numbers as JSON; a number that is not finite becomes null."""
        content = {"schema": CHECK_SCHEMA, **_plain(asdict(self))}
        return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
