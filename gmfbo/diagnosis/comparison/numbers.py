"""The one table of numbers that take part in a decision."""

from __future__ import annotations

from math import log

PRIOR_OF_COUNT = (0.45, 0.35, 0.15, 0.04, 0.01)
"""[1] Prior probability of no, one, two, three and four effects."""

FIXED_SHARE = 0.2
"""[1] Of the prior of one more element: that it is a freed fixed parameter."""

SIZE_SHARE = 0.1
"""[1] Scale of the Cauchy prior of a size, of its bound."""

FIXED_SPREAD = 0.4
"""[1] Standard deviation of the logarithm of a freed fixed parameter about its value."""

FIXED_FLOOR = 0.02
"""[1] Change of a fixed parameter below which nobody cares: values are stated to two digits."""

SHIFT_SHARE = 0.1
"""[rows] Prior of a column's shift."""

LOW_PASS_SHARE = 0.2
"""[rows] Time constant of a logger's filter, where its coordinate is small."""

SCALE_PRIOR, POSITION_SCALE_PRIOR = 0.02, 3e-4
"""[1] Current sensors are within 1-3 %, encoders exact."""

OFFSET_PRIOR = 5e-4
"""[range of the signal] Zero error of a sensor that reads no position."""

CLOCK_PRIOR = 1e-4
"""[1] Quartz clocks of two devices."""

OWN_SPREAD = 0.05
"""[1] Mean of the prior of a quantity's spread over the recordings, of its value: rigs warm up and
loads change from run to run."""

TORQUE_TIME = 0.02
"""[s] Usual correlation time of torque noise and of what a model lacks (servo prototype)."""

NOISE_FREEDOM = 4.0
"""[1] Degrees of freedom of the noise of a stretch, about its level (Lange et al. 1989)."""

BAND = 0.2
"""[Nyquist frequency] Noise levels are read above it."""

PLAYED_NOISES = 8
"""[1] Realisations of the loop's noise that are played (README's axis: 4, 8 and 16 agree)."""

BLOCK_ROWS = 128
"""[rows] Of a block in the estimate of the noise levels."""

FLOOR = 1e-4
"""[1] Share of each variance by which a spectrum is uncertain."""

TOLERANCE = 2e-5
"""[largest torque] Torque noise below which nobody cares."""

INADEQUACY_TOLERANCE = 6e-3
"""[rms torque of the drive] Mean of the prior of an inadequacy's size (linear axis prototype)."""

SMOOTH_BUMPS = 2.0
"""[bumps] Over which an inadequacy is smooth. Hidden friction (development draw, 033) was believed
to be one at 0.44 with independent bumps, at 0.16 with 1 and at 0.002 with 2."""

STRETCH_LOOP_TIMES = 5.0
"""[loop times] Least length of a stretch."""

BOOTSTRAP_DRAWS = 300
"""[1] Weightings of the stretches (Huggins and Miller 2023)."""

LEAST_GAIN = 6.0
"""[nats] Linearised gain below which a move is not fitted, but for two of the first."""

SETTLED, AT_THE_END = 0.1, 0.02
"""[nats] Gain that a step promises, below which a search has ended. Evidence is that of a
parabola's top, whether or not a search has come there; values that are told come to the end
(README's axis: 3,697 simulations with 0.02 alone, 2,316 with 0.1, the same name and level)."""

HOPED_STEPS = 10.0
"""[1] Steps as good as its next one that a fit may still make: as many as a search takes."""

FAR_BEHIND = 10.0
"""[nats] Behind the best fit by more than these steps gain, a fit is not searched on: odds of 1 to
20,000 (draw case 037: 5,913 simulations without, 4,077 with it, the same names)."""

NAMED = 0.95
"""[1] Posterior inclusion of what is said."""

WORTH = (-1.81, 0.58, 0.53)
"""[1] Line of what a claim is worth: where it starts, by the log odds of its belief, and by
the logarithm of the nats it gains (200 claims of the second registered draw,
tests.blind.draw.worth)."""

MOST_TOLD = 1000.0
"""[nats] More say nothing more: of claims that gained 1,000 to 3,000 96 % were right, of those that
gained more than 10,000 91 % (first registered draw)."""

MOST_SAID = 0.9
"""[1] Most probability that is told of a name: what beliefs are worth was counted on simulated
axes, and of real ones nobody knows the truth."""

DOUBTED = 0.75
"""[1] Most that is told of what would not be said without its best stretch, of friction where no
recording reverses, and of names that leave most of what is more than noise: of those 22 of 43 were
right (the first draw)."""

FEW_STRETCHES = 8
"""[1] With fewer, those beside the best one are no part of its event: three of them may be all."""

UNLIKE = 0.03
"""[1] Share of an effect's change that no parameter makes, below which it is not testable."""

MOST = 0.5
"""[1] Share that is most of something."""

SAME = 4.0
"""[1] Squared whitened distance of two predictions that are the same: two standard deviations."""

TOLD_APART = 30.0
"""[1] Squared whitened distance that tells two predictions apart: noise alone gives 15."""


def named_log_odds() -> float:
    """[nats] Log odds from which something is said."""
    return log(NAMED / (1.0 - NAMED))
