"""Recordings held against their twin, before anything is fitted.

`usable.usable` unwraps angles (`wrapped_angle`), names compared signals that a recording lacks
(`missing_signals`), and refuses what contradicts the twin (`contradiction`), such as a column in a
`mistaken_unit`. `likeness.likeness` tells shape, size and sign of a signal.
"""
