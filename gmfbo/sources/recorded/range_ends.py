"""Whether an uncertain parameter of the twin may be why a recording differs so much from it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.likeness import MIDWAY, SAME_SHAPE, Likeness
from gmfbo.sources.twin.twin import FmuTwin


def at_range_ends(twin: FmuTwin, recording: Recording) -> Iterator[Recording]:
    """Simulations with one uncertain parameter at an end of its range each.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recording : Recording
        Run of the real axis.
    """
    for name, ends in twin.file.uncertain.items():
        for value in ends:
            variable = twin.binding.variables[name].variable
            low = -math.inf if variable.minimum is None else variable.minimum
            high = math.inf if variable.maximum is None else variable.maximum
            run = twin.run({}, recording, parameters={name: min(max(value, low), high)})
            if run.status == "ok":
                yield run


def explains(then: Likeness | None, seen: Likeness | None) -> bool:
    """Whether an end of a range brings the size most of the way, or turns the sign.

    A run in which less than half of the recorded motion is found, as of a loop that becomes
    unstable at that end, explains nothing: its size is not that of the recorded motion.

    Parameters
    ----------
    then : Likeness or None
        Of the recorded signal to the run at the end of the range; None where that stands still.
    seen : Likeness or None
        Of the recorded signal to the run of the twin as it is.
    """
    if then is None or seen is None or abs(then.shifted) < MIDWAY:
        return False
    if seen.is_flipped:
        return then.correlation > 0.0
    if seen.correlation < SAME_SHAPE:  # another motion as the twin is, and not at this end
        return True
    if then.gain <= 0.0:
        return False
    # Where the shapes differ, the gain is smaller than the ratio of the motions: both have to fit.
    away = max(abs(math.log(then.motion)), abs(math.log(then.gain)))
    return away < 0.5 * abs(math.log(seen.motion))
