"""Name the missing effects, each confirmed on stretches left out of its fit.

`forward_selection.decide` makes the `decision.Decision`, `probability.probability` tells how far
it can be trusted, and `withdrawn_names` takes back names that later evidence contradicts.
`decision_told.named_effects` and `open_explanations.predictions_of` put it into the result.
"""
