"""Show what is missing that the library of effects does not hold.

`free_function.unnamed` infers it as a function of one state, at one port of the twin.
"""
