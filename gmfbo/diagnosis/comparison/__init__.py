"""Compare hypotheses about a twin by one score, the evidence of all recordings.

`opened_comparison.comparison_of` states the problem, `search.Search` fits hypotheses best first,
and `evidence.log_evidences` scores them under weightings of the recordings' stretches.
Noise has three places, `noise.places.Levels`, and every hypothesis the same inadequacy.
`gmfbo.diagnosis.naming.decided_by_score` turns the beliefs into names and sets.
"""
