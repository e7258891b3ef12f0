"""What was decided about missing effects, and the evidence that it rests on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted as Row
from gmfbo.diagnosis.comparison.ledger import Ledger, Scored
from gmfbo.diagnosis.comparison.moves import Shown
from gmfbo.diagnosis.comparison.numbers import INADEQUACY_TOLERANCE, MOST
from gmfbo.diagnosis.comparison.search import Search
from gmfbo.diagnosis.comparison.unknown.beside import Unknown
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.worth import as_told
from gmfbo.diagnosis.result.named_effect import RivalShare


@dataclass(frozen=True, eq=False)
class Evidence:
    """One of the explanations that share a place.

    Attributes
    ----------
    name : str
        An effect, or `parameter:NAME`.
    fitted : Fitted
        The twin with it, and with all else that was decided.
    """

    name: str
    fitted: Fitted

    @property
    def effect(self) -> Candidate:
        """The effect at its fitted values; a parameter has none."""
        return next(c for c in self.fitted.hypothesis.effects if c.effect == self.name)


@dataclass(frozen=True, eq=False)
class Round:
    """One effect accepted, and what cannot be told from it.

    Attributes
    ----------
    winner : Evidence
        What is believed most.
    rivals : tuple of Evidence
        What explains the recordings as well.
    belief : float
        That one of them is at work, by the comparison.
    probability : float
        The same, as it is told: what such a belief is worth.
    shares : tuple of RivalShare
        The parts of that, where there are rivals.
    gain : float
        [nats] Log odds against the best hypothesis without any of them.
    per_recording : mapping of str to float
        What of the whitened square falls in each recording.
    once : str
        Stretch without which it would not be said; empty where others tell it as well.
    most : float
        Largest probability that may be told.
    """

    winner: Evidence
    rivals: tuple[Evidence, ...]
    belief: float
    probability: float
    shares: tuple[RivalShare, ...]
    gain: float
    per_recording: Mapping[str, float]
    once: str = ""
    most: float = 1.0

    def held_against(self, left: float) -> Round:
        """The same as told once the model has met held-out recordings.

        Parameters
        ----------
        left : float
            Share of what is more than noise there that it does not explain.
        """
        probability = as_told(self.belief, self.gain, self.most, left)
        shares = tuple(
            replace(one, probability=probability / self.probability * one.probability)
            for one in self.shares
        )
        return replace(self, probability=probability, shares=shares)

    @property
    def names(self) -> tuple[str, ...]:
        """The set, the most believed first."""
        return (self.winner.name, *(rival.name for rival in self.rivals))


@dataclass(frozen=True)
class WrongValue:
    """A fixed parameter of the twin that the recordings contradict.

    Attributes
    ----------
    set : tuple of str
        Itself first, as `parameter:NAME`, and those of which they do not tell that it is not they.
    belief : float
        That one of them is wrong, by the comparison.
    gain : float
        [nats] Log odds against the best hypothesis that frees none of them.
    probability : float
        The belief, as it is told. What beliefs are worth was counted on effects; of 65 fixed
        parameters told in two registered draws 63 were right.
    most : float
        Most that is told.
    """

    set: tuple[str, ...]
    belief: float
    gain: float
    probability: float
    most: float = 1.0

    def held_against(self, left: float) -> WrongValue:
        """The same as told once the model has met held-out recordings, as of a `Round`."""
        return replace(self, probability=as_told(self.belief, self.gain, self.most, left))


@dataclass(frozen=True, eq=False)
class Compared:
    """The comparison that a decision rests on.

    Attributes
    ----------
    search : Search
        The problem, and what competed.
    ledger : Ledger
        Fitted hypotheses.
    scored : Scored
        Their beliefs.
    """

    search: Search
    ledger: Ledger
    scored: Scored


@dataclass(frozen=True, eq=False)
class Decision:
    """What was accepted.

    Attributes
    ----------
    rounds : tuple of Round
        One for each accepted effect, those with the largest gain first.
    freed : mapping of str to WrongValue
        Fixed parameters of the twin that the recordings contradict, by name.
    model : Fitted
        The twin with all of this.
    row : Row
        The same in the comparison.
    base : Row
        The twin with its uncertain parameters refitted.
    threshold : float
        [nats] Log odds of what is believed at 0.95.
    shown : tuple of Shown
        How well each effect at its start would have been seen.
    untestable : mapping of str to str
        Effects that cannot be told, and why: mostly a parameter of the twin does the same, or the
        twin runs away with them.
    share : float or None
        Of what the refitted twin leaves beyond noise, explained; None where it leaves no more.
    unknown : Unknown or None
        What is believed to act that no law holds.
    notes : tuple of str
        Why what explains the recordings is not named.
    nearest : Row or None
        The same as `row`, with the laws in whose place the unknown is believed: what the library
        has that comes nearest to it.
    stand_ins : tuple of str
        Of these laws, those that the model holds.
    unsettled : frozenset of str
        Effects that were believed, told or not, and those that what is unknown could hide.
    is_withdrawn : bool
        Held-out recordings contradict all that was believed.
    """

    rounds: tuple[Round, ...]
    freed: Mapping[str, WrongValue]
    model: Fitted
    row: Row
    base: Row
    threshold: float
    shown: tuple[Shown, ...]
    untestable: Mapping[str, str]
    share: float | None
    compared: Compared
    unknown: Unknown | None = None
    notes: tuple[str, ...] = field(default=())
    nearest: Row | None = None
    stand_ins: tuple[str, ...] = ()
    unsettled: frozenset[str] = frozenset()
    is_withdrawn: bool = False

    @property
    def is_outside(self) -> bool:
        """Whether something acts that the laws of the library do not explain.

        A torque without any law that is as large as half of the drive's is no noise of the shaft.
        """
        if self.share is None or self.is_withdrawn:
            return self.share is not None
        if self.unknown is not None:
            return True
        usual = self.compared.search.tolerance / INADEQUACY_TOLERANCE
        level = self.compared.ledger.levels.missing("torque")
        return self.share < MOST and level > MOST * usual

    @property
    def shown_unknown(self) -> Unknown | None:
        """What is unknown, where its function stands beside nothing but what is told."""
        told = {name for found in self.rounds for name in found.names}
        told |= {f"parameter:{name}" for name in self.freed}
        if self.unknown is None or not self.is_outside or self.unknown.beside - told:
            return None
        return self.unknown
