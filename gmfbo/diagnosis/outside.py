"""Whether something is missing that the library does not hold."""

from __future__ import annotations

from dataclasses import dataclass

from gmfbo.diagnosis.case import Case
from gmfbo.diagnosis.decision import Decision
from gmfbo.diagnosis.port_response import PortResponse
from gmfbo.diagnosis.shape import Unnamed, unnamed

_BETTER = 0.7  # a name that explains less than this share of what a free function does is none
_THRESHOLDS = 3.0  # that a free function has to gain: it has a dozen values
_EXCESS_SHARE = 0.3  # of what is left beyond noise, which it has to take away


@dataclass(frozen=True, eq=False)
class Outside:
    """A free function of one state against the names.

    Attributes
    ----------
    model : Unnamed
        Fitted about the twin with its parameters refitted.
    gain : float
        Fall of chi2 on what was left out, by the best function of a state.
    named : float
        The same by all named effects together.
    is_better : bool
        The function explains what no name does.
    """

    model: Unnamed
    gain: float
    named: float
    is_better: bool


def look_outside(case: Case, decision: Decision, response: PortResponse) -> Outside:
    """Compare the named effects with a free function of velocity or position.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        What was named.
    response : PortResponse
        From the torque port to the signals.
    """
    model = unnamed(case, case.base, response)
    shared = [f for f in model.families if f.family.shared]
    gain = max((f.gain for f in shared), default=0.0)
    assert decision.model is not None
    named = case.base.chi2 - decision.model.chi2
    excess = case.base.chi2 * (1.0 - 1.0 / decision.dispersion)
    needed = max(_THRESHOLDS * decision.threshold, _EXCESS_SHARE * excess)
    return Outside(model, gain, named, gain > needed and named < _BETTER * gain)
