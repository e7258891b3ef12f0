"""Measure the noise of the recordings, and what the control loop makes of it.

`measured_noise.noise_of_all` measures it, `measured_noise.noise_through_loop` carries it round
the loop, and `loop_noise.own_variances` tells what each signal has of its own.
`open_loop_noise.leave_out_noise` keeps it out of a plant that is driven in open loop. What the
controller read is told by `gmfbo.diagnosis.comparison.hearing` and played into the twin.
"""
