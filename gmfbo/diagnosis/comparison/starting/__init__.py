"""Where the fits of effects begin.

`pointed_starts` picks, of many starts of a limit, those that what the twin leaves points to.
"""
