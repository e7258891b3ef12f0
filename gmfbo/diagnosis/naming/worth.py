"""What a belief is worth: how often claims that were believed as much turned out right.

Beliefs weigh the hypotheses of the search against each other, as if one of them were true. None is:
laws are of the wrong form, noise is not what it is taken for, and odds of a thousand nats are then
no certainty. How often claims were right was counted, and that is what is printed.
"""

from __future__ import annotations

import numpy as np
from scipy.special import expit, logit

from gmfbo.diagnosis.comparison.numbers import DOUBTED, MOST, MOST_SAID, MOST_TOLD, WORTH

LAST_DIGIT = 0.005
"""Half of the last digit of a probability: a belief counts as no nearer to 0 or 1."""


def worth(belief: float, gain: float) -> float:
    """Probability that a claim is right, calibrated on cases whose truth is known.

    A logistic line over the log odds of the belief (Cox 1958, "Two further applications of a model
    for binary regression", eq. 1), and over the logarithm of what the recordings have gained by it:
    where beliefs are all next to 1, that still tells weak claims from strong ones.

    Parameters
    ----------
    belief : float
        That one of a set is at work, by the comparison.
    gain : float
        [nats] Log odds of the best hypothesis with one of them against the best without any; less
        than 1 counts as 1, and more than `MOST_TOLD` as that.
    """
    return float(expit(np.dot(WORTH, terms(belief, gain))))


def as_told(belief: float, gain: float, most: float, left: float = 0.0) -> float:
    """Probability that is told of a claim.

    Parameters
    ----------
    belief, gain : float
        As of `worth`.
    most : float
        Most that is told of it, whatever it is worth.
    left : float
        As of `most_told`; as if all were explained by default.
    """
    return min(worth(belief, gain), most, most_told(left))


def terms(belief: float, gain: float) -> tuple[float, float, float]:
    """What the three numbers of `WORTH` multiply; arguments as for `worth`."""
    odds = logit(np.clip(belief, LAST_DIGIT, 1.0 - LAST_DIGIT))
    return 1.0, float(odds), float(np.log(np.clip(gain, 1.0, MOST_TOLD)))


def most_told(left: float) -> float:
    """Largest probability that is told of a name beside held-out recordings.

    Parameters
    ----------
    left : float
        Share of what is more than noise there that no name explains.
    """
    return MOST_SAID if left <= MOST else DOUBTED
