"""Fit a hypothesis through the FMU: parameters, nuisances and left-out effects.

`fit.fit` minimises the chi2 of a `misfit.Misfit` over a `hypothesis.Hypothesis` and gives a
`fit.Fitted`; `intervals.estimated` puts its parameters into the result.
`linear_left_out.square_after_refit` scores a model on stretches left out of its fit, and
`regression.Regression` fits columns to residuals.
"""
