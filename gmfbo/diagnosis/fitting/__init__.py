"""Fit a hypothesis through the FMU: parameters, nuisances and left-out effects.

`fit.fit` minimises the chi2 of a `misfit.Misfit` over a `hypothesis.Hypothesis` and gives a
`fit.Fitted`; `intervals.estimated` and `profile_intervals.widened_by_profile` tell how sure it
is. `simulated_left_out.simulated_left_out` and `linear_left_out.square_after_refit` score a
model on stretches left out of its fit, and `regression.Regression` fits columns to residuals.
"""
