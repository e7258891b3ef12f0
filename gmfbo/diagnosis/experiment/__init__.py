"""Propose the next recording, and compare what it shows with what was predicted.

`choice.choose` takes what separates rivals best, or excites what was not excited so far: for
`from_recordings.propose` among variations of the recordings, and for
`within_limits.propose_experiment` among safe motions within `play_limits.PlayLimits`. The latter
gives a `proposal.ProposedExperiment`. `predicted_against_observed.confirm_with` judges the new
recording, as an `observed.Confirmation`.
"""
