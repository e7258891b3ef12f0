"""Levels of noise about a fit.

`places` has its three places, read at high frequencies; `whole_band` tells what is missing at the
torque and command ports from white noise that was hidden there. `unseen_rows` has what noise did
before a recording began, `slow_rounding` what rounding makes of a position that moves slowly,
`unseen_input` what an input did between its rows.
"""
