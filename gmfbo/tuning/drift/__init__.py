"""Detect that the plant changed while it was tuned, with a bound on false alarms.

`drift.first_drift` finds a `drift.Drift` in the runs; `change_point` weighs the evidence.
"""
