"""Where the fits of effects begin.

`pointed_starts` picks, of an effect's many further starts, those that recordings point to.
"""
