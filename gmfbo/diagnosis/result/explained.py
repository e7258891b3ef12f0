"""How much of a mismatch the named laws explain, and what is left of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Share:
    """Share of what the refitted twin leaves beyond noise, with its 95 % interval.

    On held-out recordings, in whitened squares: `1 - (E_aug^2 - E_noise^2) /
    (E_par^2 - E_noise^2)`.

    Attributes
    ----------
    value : float
        Dimensionless; 1 where nothing but noise is left.
    low, high : float
        Ends of the interval, by a bootstrap over stretches.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Resembled:
    """A law that a function without a name looks like; no claim that it acts.

    Attributes
    ----------
    effect : str
        Name in the catalogue.
    share : float
        Of the function's square that the law makes in proportion, dimensionless, beside a constant
        and what the twin's own parameters make.
    """

    effect: str
    share: float


@dataclass(frozen=True)
class Remainder:
    """What no law explains.

    Attributes
    ----------
    share : float
        Of what the refitted twin leaves beyond noise, dimensionless; what is given above 1 is 1.
    port : str or None
        Port at which a smooth signal stands for it; None where none does.
    against : str or None
        On what that signal depends: `velocity`, `position`, `command` or `time` since the start.
    where : str
        Stretch that holds more than half of it, or "throughout".
    resembles : Resembled or None
        Law that makes most of that signal; None where none does.
    stand_ins : tuple of str
        Laws that the corrected twin has in its place, since they come nearest; no claim that they
        act. `share` is what they leave.
    """

    share: float
    port: str | None
    against: str | None
    where: str
    resembles: Resembled | None = None
    stand_ins: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        # Laws may leave more on held-out recordings than the refitted twin does: all is left then.
        object.__setattr__(self, "share", min(self.share, 1.0))


@dataclass(frozen=True)
class FreeRun:
    """NRMSE of an open-loop twin over whole held-out recordings, with nothing that corrects it.

    All are dimensionless; NaN where there is no such model.

    Attributes
    ----------
    nominal, parameters_only, augmented : float
        As of `SignalFit`.
    """

    nominal: float
    parameters_only: float
    augmented: float
