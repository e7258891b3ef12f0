"""Effects in a diagnosis: named, not testable, and smallest detectable sizes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gmfbo.diagnosis.result.explained import Share


@dataclass(frozen=True)
class IdentifiedValue:
    """Identified value of one parameter of an effect, with its 95 % interval.

    Attributes
    ----------
    value : float
        [unit] Estimate, the default in the augmented twin.
    unit : str
        Unit, following that of the port.
    low, high : float
        [unit] Ends of the interval.
    """

    value: float
    unit: str
    low: float
    high: float


@dataclass(frozen=True)
class RivalShare:
    """One of the explanations that cannot be told apart.

    Attributes
    ----------
    name : str
        The effect itself, or a rival.
    probability : float
        Its own posterior probability.
    """

    name: str
    probability: float


@dataclass(frozen=True)
class NamedEffect:
    """Physics that the twin leaves out and the recordings show.

    Attributes
    ----------
    name : str
        Name in the catalogue, such as `coulomb_friction`.
    port : str
        Where it acts: `torque`, `command` or `sensor`.
    probability : float
        That this effect is at work: what a belief as strong was worth where the truth is known.
    statement : str
        One sentence in plain words, ending in a full stop. Below a `set_probability` of 0.8 its
        verb is "may"; of a set it names all members.
    equation : str
        Its law, in text.
    parameters : mapping of str to IdentifiedValue
        Identified values by parameter name.
    evidence : float
        [nats] Log odds against the best hypothesis without it and without what cannot be told
        from it.
    threshold : float
        [nats] Log odds of what is believed at 0.95.
    evidence_per_recording : mapping of str to float
        Fall of the whitened square in each recording, dimensionless.
    indistinguishable_from : tuple of str
        Effects that explain these recordings equally well; a parameter of the twin is
        `parameter:NAME`.
    rivals : tuple of RivalShare
        The effect and these, each with its own probability; none without rivals.
    share : Share or None
        Of what the refitted twin leaves beyond noise on held-out recordings: what this effect
        explains. None where there is next to nothing to explain.
    belief : float or None
        Posterior probability that this effect, or one of those that cannot be told from it, is at
        work, if one of the hypotheses were true; None in diagnoses made before it was told.
    """

    name: str
    port: str
    probability: float
    statement: str
    equation: str
    parameters: Mapping[str, IdentifiedValue]
    evidence: float
    threshold: float
    evidence_per_recording: Mapping[str, float]
    indistinguishable_from: tuple[str, ...] = ()
    rivals: tuple[RivalShare, ...] = ()
    share: Share | None = None
    belief: float | None = None

    @property
    def set_probability(self) -> float:
        """Probability that this effect, or one that it cannot be told from, is at work."""
        if not self.rivals:
            return self.probability
        return min(sum(rival.probability for rival in self.rivals), 1.0)

    @property
    def set(self) -> tuple[str, ...]:
        """Effects that these recordings cannot tell apart, this one first."""
        return (self.name, *self.indistinguishable_from)


@dataclass(frozen=True)
class NotTestable:
    """An effect that cannot be tested with these recordings or this twin.

    Attributes
    ----------
    name : str
        Name in the catalogue.
    why : str
        The reason, such as "not excited: no reversal" or "is parameter mech.J".
    """

    name: str
    why: str


@dataclass(frozen=True)
class DetectableSize:
    """Smallest size of an effect that these recordings would have shown.

    Attributes
    ----------
    parameter : str
        Parameter of the effect that is its size.
    size : float
        [unit] Its smallest detectable magnitude.
    unit : str
        Unit of the size.
    """

    parameter: str
    size: float
    unit: str
