"""Fit a hypothesis through the FMU: parameters, nuisances and left-out effects.

`fit.fit` minimises the chi2 of a `misfit.Misfit` over a `hypothesis.Hypothesis` and gives a
`fit.Fitted`; `intervals.estimated` puts its parameters into the result.
`regression.Regression` fits columns to residuals, scored by `linear_left_out.Normal` on what was
left out.
"""
