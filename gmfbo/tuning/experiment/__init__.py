"""The experiment that every source repeats: references played, answers scored.

`experiment_series.ExperimentSeries` scores several references in one objective;
`joined_runs.ended_by` tells whether a joined run ended early; `run_values.values_of_runs` gives
numbers of each run in which a change of the plant shows.
"""
