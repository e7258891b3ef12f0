"""Ask whether something is missing that the library of effects does not hold.

`beyond_library.look_outside` compares the named effects with a free function of one state, and
`beyond_library.unexplained` tells whether a mismatch remains that no name explains.
"""
