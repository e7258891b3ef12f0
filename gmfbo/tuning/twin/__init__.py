"""Runs of the twin beside the real ones, and a twin corrected during a study.

`twin_runs.TwinRuns` runs the twin without being asked, `runs_beside.runs_beside` at the gains of
the real runs, and `closer_look.look_closer` around promising gains. A `twin_version.TwinRefiner`
corrects the twin and gives a `twin_version.TwinVersion`.
"""
