"""Propose the next recording, and compare what it shows with what was predicted.

`from_recordings.propose` chooses among variations of the recordings, and
`within_limits.propose_experiment` among safe motions within `play_limits.PlayLimits`; the latter
gives a `proposal.ProposedExperiment`. `predicted_against_observed.confirm_with` judges the new
recording, as an `observed.Confirmation`.
"""
