"""Open a case: a twin and its recordings, measured, aligned and refitted.

`open_case.open_case` makes the `case.Case` that all later steps share, and
`open_case.open_unseen` one of other recordings; `measured_budget.measured_budget` tells how large
their residuals may be. `held_out_split.split_of` sets the held-out recordings apart,
`command_signal.command_of` finds the controller's command, and `tracking.tracking_loop` keeps an
open-loop twin near its recordings.
"""
