"""The runs of a study, kept on disk before they count, and the state they leave.

`history.History` records trials; `state.TuningState` is what a method may know;
`incumbent.best_run` finds the best run; `query_cost` holds the cost of a run.
"""
