"""An effect that a twin may lack: requirements, law and words."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from gmfbo.errors import InputError, did_you_mean
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask, States
from gmfbo.units import quantity

_LEAST_KEPT = 1e-3  # of the shaft's inertia that remains when a load is split off

_TERM = re.compile(r"([A-Za-z]+|1)(\d*)")
_PLAIN = ("s", "Hz", "1")

Values = Mapping[str, float]
Range = Callable[[Excitation], float]


@dataclass(frozen=True)
class Units:
    """The units of one twin's port and states, as its FMU spells them.

    Attributes
    ----------
    torque : str
        Of the torque port: `N.m`, or `N` on a linear axis.
    position, velocity : str
        Of the shaft: `rad` and `rad/s`, or `m` and `m/s`.
    command, current : str
        Of the actuator command and of what stands for the current.
    load : str
        Of what stands for the load: the torque's where a load torque is known, else the current's.
    """

    torque: str = "N.m"
    position: str = "rad"
    velocity: str = "rad/s"
    command: str = "N.m"
    current: str = "N.m"
    load: str = "N.m"

    @property
    def place(self) -> str:
        """Where a torque acts, in words: on a shaft or on a linear axis."""
        return "at the motor shaft" if self.position == "rad" else "on the axis"

    @property
    def torque_word(self) -> str:
        """What acts at the torque port: a torque on a shaft, a force on a linear axis."""
        return "torque" if self.position == "rad" else "force"

    def resolve(self, expression: str) -> str:
        """Write the unit of a parameter, such as `torque/velocity`, for this twin.

        Parameters
        ----------
        expression : str
            Words torque, position, velocity, command, current, load, inertia, s, Hz and 1, with a
            power where needed (`velocity2`), and at most one `/`.

        Returns
        -------
        str
            Readable rather than reduced: `N.m/(rad/s)`, `1/rad`, `kg.m2`; `1` where all cancels.

        Raises
        ------
        InputError
            The expression has another word.
        """
        above, _, below = expression.partition("/")
        top = self._term(above)
        if not below:
            return top
        bottom = self._term(below)
        if top == bottom:
            return "1"
        return f"{_bracketed(top)}/{_enclosed(bottom)}"

    def _term(self, text: str) -> str:
        found = _TERM.fullmatch(text.strip())
        words = ("torque", "position", "velocity", "command", "current", "load", "inertia")
        if found is None or found[1] not in (*words, *_PLAIN):
            raise InputError(
                f"no unit '{text}'" + did_you_mean(text, (*words, *_PLAIN)) + "; correct the effect"
            )
        word, power = found[1], found[2]
        if word in _PLAIN:
            return word + power
        unit = self._inertia() if word == "inertia" else str(getattr(self, word))
        return re.sub("[A-Za-z]+", rf"\g<0>{power}", unit) if power else unit

    def _inertia(self) -> str:
        known = {("N.m", "rad"): "kg.m2", ("N", "m"): "kg"}
        found = known.get((self.torque, self.position))
        return found or f"{_bracketed(self.torque)}/({self.position}/s2)"


@dataclass(frozen=True)
class EffectParameter:
    """A parameter of an effect that is fitted to recordings.

    Attributes
    ----------
    name : str
        As in `physics.fmu`: its variable there is `effect.name`.
    words : str
        Description for a table.
    unit : str
        Expression over the words of `Units`: `torque/velocity`.
    low, high : callable
        Bounds for an excitation; an amplitude that must be positive has the lower bound 0.
    scale : callable
        Typical size, by which the optimiser scales its steps; positive.
    hidden : bool
        Whether it is fitted, but no headline number.
    """

    name: str
    words: str
    unit: str
    low: Range
    high: Range
    scale: Range
    hidden: bool = False


def positive(
    name: str, words: str, unit: str, shown: Range, most: float = 1.0, typical: float = 0.07
) -> EffectParameter:
    """Make an amplitude between 0 and `most` times the size shown by the excitation.

    Parameters
    ----------
    name, words, unit : str
        As in EffectParameter.
    shown : callable
        Size shown by an excitation, in the parameter's unit.
    most, typical : float
        Largest and typical size, as shares of what is shown.
    """
    return EffectParameter(
        name,
        words,
        unit,
        low=lambda e: 0.0,
        high=lambda e: most * shown(e),
        scale=lambda e: typical * shown(e),
    )


def signed(
    name: str, words: str, unit: str, shown: Range, most: float = 1.0, typical: float = 0.07
) -> EffectParameter:
    """Make an amplitude of either sign, up to `most` times the size shown by the excitation.

    Parameters
    ----------
    name, words, unit : str
        As in EffectParameter.
    shown : callable
        Size shown by an excitation, in the parameter's unit.
    most, typical : float
        Largest and typical size, as shares of what is shown.
    """
    amplitude = positive(name, words, unit, shown, most, typical)
    return replace(amplitude, low=lambda e: -most * shown(e))


def sentence(text: str, **names: str) -> Callable[[Values, Units, str], str]:
    """Make the statement of an effect from a text with blanks.

    Parameters
    ----------
    text : str
        `{name}` is a parameter's value with its unit; `{place}` and `{torque_word}` are of `Units`.
    **names : str
        Unit of each parameter in the text, as in EffectParameter.
    """

    def statement(parameters: Values, units: Units, place: str) -> str:
        told = {
            name: quantity(parameters[name], units.resolve(unit)) for name, unit in names.items()
        }
        return text.format(place=place, torque_word=units.torque_word, **told)

    return statement


def _nothing_fixed(excitation: Excitation) -> Values:
    return {}


_LINEAR = frozenset({"timing", "gain", "inertia", "sensor"})


def _no_more(excitation: Excitation) -> Sequence[Values]:
    return ()


def _nowhere_gone(parameters: Values, excitation: Excitation) -> Values:
    return {}


def _always_excited(excitation: Excitation) -> str | None:
    return None


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One left-out effect of the catalogue; `physics.fmu` holds its equations.

    Attributes
    ----------
    name, port : str
        As in `physics.fmu`; the port is `torque`, `command` or `sensor`.
    family : str
        friction, spring, harmonic, timing, limit, gain, inertia, sensor or disturbance.
    signal_path : str
        controller, actuator, plant, transmission or sensor.
    parameters : tuple of EffectParameter
        Fitted parameters, the headline first.
    starts : callable (Excitation) -> sequence of mapping
        Start values for the fit; each is screened separately.
    more_starts : callable (Excitation) -> sequence of mapping
        Too many to simulate all of them; a search picks those that recordings point to.
    gone : callable (parameters, Excitation) -> mapping
        Of an effect without a size that may be zero: parameters nearest to these ones, other than
        they are there, at which it changes nothing.
    begins_whole : bool
        Whether a fit that begins with less of it ends with next to none.
    size : callable (parameters, Excitation) -> float
        Size of the effect, at least 0.
    size_name, size_unit : str
        Name of that size, and its unit as an expression over the words of `Units`.
    floor : callable (Excitation) -> float
        Size below which the effect is never claimed.
    acts : callable (States, parameters) -> ndarray (n,) of bool
        Samples at which the effect shows most.
    region : callable (parameters, Units) -> str
        Words for these samples, which contain `region_state`.
    region_state : str
        velocity, position, command, current, acceleration or time.
    statement : callable (parameters, Units, place) -> str
        One plain sentence with number and unit; `place` is `Units.place`.
    equation, source : str
        The law in ASCII, and its publication.
    fixed : callable (Excitation) -> mapping
        Parameters of `physics.fmu` that are set, not fitted.
    own_nuisances : tuple of EffectParameter
        Those of the fixed parameters that nobody asks for and that a comparison of hypotheses
        estimates, so that no other law makes up for their value.
    signal : callable (States, parameters) -> ndarray (n,) or None
        Signal added to the port on a given trajectory, without feedback; None where the effect
        has motion of its own and must be simulated.
    feature : callable (States) -> ndarray (n,) or None
        That signal for unit size at its typical shape: for screening and location.
    not_excited : callable (Excitation) -> str or None
        Reason why these recordings cannot show it, or None.
    shows_at_turns : bool
        Whether its own form shows only where the axis turns: a motion one way shows no more of it
        than of a simpler law.
    requires : tuple of str
        Required states beyond position and command. Velocity and current are not listed: the
        position is differentiated, and the command replaces an unknown current.
    inertia_share : bool
        Whether its `load_inertia` is split off the twin's inertia; the rest is passed as
        `shaft_inertia`, since a hard joint moves both within a step.
    acts_at_rest : bool
        Whether it pushes or moves an axis that stands still under its first reference.
    contains : tuple of str
        Simpler effects that are limiting cases of it.
    as_limit : mapping of str to str
        By parameter: that of the simpler effect whose value it has where this one is that one.
    confused_with : mapping of str to str
        By other effect: the excitation that separates the two.
    parameter_like : tuple of str
        Roles of twin parameters with the same signature.
    """

    name: str
    port: str
    family: str
    signal_path: str
    parameters: tuple[EffectParameter, ...]
    starts: Callable[[Excitation], Sequence[Values]]
    size: Callable[[Values, Excitation], float]
    size_name: str
    size_unit: str
    floor: Range
    acts: Callable[[States, Values], Mask]
    region: Callable[[Values, Units], str]
    region_state: str
    statement: Callable[[Values, Units, str], str]
    equation: str
    source: str
    fixed: Callable[[Excitation], Values] = _nothing_fixed
    more_starts: Callable[[Excitation], Sequence[Values]] = _no_more
    gone: Callable[[Values, Excitation], Values] = _nowhere_gone
    begins_whole: bool = False
    own_nuisances: tuple[EffectParameter, ...] = ()
    signal: Callable[[States, Values], Array] | None = None
    feature: Callable[[States], Array] | None = None
    not_excited: Callable[[Excitation], str | None] = _always_excited
    shows_at_turns: bool = False
    requires: tuple[str, ...] = ()
    inertia_share: bool = False
    acts_at_rest: bool = False
    contains: tuple[str, ...] = ()
    as_limit: Mapping[str, str] = field(default_factory=dict)
    confused_with: Mapping[str, str] = field(default_factory=dict)
    parameter_like: tuple[str, ...] = ()

    @property
    def is_searched(self) -> bool:
        """Whether its place is found by a search: a line over position or time, or an instant."""
        names = {parameter.name for parameter in self.parameters}
        return bool(names & {"wavenumber", "wavenumber_1", "frequency", "start"})

    @property
    def is_linear(self) -> bool:
        """Whether noise passes it as it would a filter."""
        return self.family in _LINEAR or self.name == "torsional_compliance"

    @property
    def is_line(self) -> bool:
        """Whether it repeats over position or time."""
        return self.is_searched and not self.is_passing

    @property
    def is_passing(self) -> bool:
        """Whether it acts once, from an instant found by a search."""
        return "start" in {parameter.name for parameter in self.parameters}

    def bounds(self, excitation: Excitation) -> dict[str, tuple[float, float]]:
        """Lower and upper bound of each fitted parameter, by name.

        Parameters
        ----------
        excitation : Excitation
            Excitation by the recordings.
        """
        free = (*self.parameters, *self.own_nuisances)
        return {p.name: (p.low(excitation), p.high(excitation)) for p in free}

    def scales(self, excitation: Excitation) -> dict[str, float]:
        """Typical size of each fitted parameter, by name.

        Parameters
        ----------
        excitation : Excitation
            Excitation by the recordings.
        """
        free = (*self.parameters, *self.own_nuisances)
        return {p.name: p.scale(excitation) for p in free}

    def variables(self, parameters: Values, excitation: Excitation) -> dict[str, float]:
        """Variables of `physics.fmu` that switch the effect on with these parameters.

        Parameters
        ----------
        parameters : mapping of str to float
            Fitted ones, and further ones of the effect (another line of cogging).
        excitation : Excitation
            Decides the fixed parameters.

        Returns
        -------
        dict of str to float
            `effect.parameter` = value; a `shaft_inertia` by the twin's nominal one.
        """
        together = {**self.fixed(excitation), **parameters}
        if self.inertia_share:
            left = excitation.shaft_inertia - together["load_inertia"]
            together.setdefault("shaft_inertia", max(left, _LEAST_KEPT * excitation.shaft_inertia))
        return {f"{self.name}.{name}": float(value) for name, value in together.items()}


def _bracketed(unit: str) -> str:
    return f"({unit})" if "/" in unit else unit


def _enclosed(unit: str) -> str:
    return f"({unit})" if "/" in unit or "." in unit else unit
