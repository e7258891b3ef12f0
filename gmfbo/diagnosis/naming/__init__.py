"""Name the missing effects by what the comparison of hypotheses says.

`decided_by_score.decide` makes the `decision.Decision`. `decision_told.named_effects`,
`alignment_told.alignments` and `open_explanations.predictions_of` put it into the result, and
`shown_sizes.detectable_sizes` tells from which size the other effects would have shown.
"""
