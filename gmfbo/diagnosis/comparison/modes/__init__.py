"""The most likely values of one hypothesis.

`posterior_mode` searches them through the FMU, `nuisance_steps` lets the nuisances follow, and
`trial_points` simulates the hypothesis and takes differences.
"""
