"""Queries: proposals of a method, runs that are asked for, the initial design.

A method has the interface `method.Method` and gives a `method.Proposal`, which becomes a
`request.TrialRequest`; a study ends as a `request.TuningResult`. `initial_design.initial_points`
gives the first gains, and `progress.Progress` goes to whoever watches.
"""
