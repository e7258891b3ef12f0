"""The library of effects: one effect a file, named as in the catalogue.

`gmfbo.physics.CATALOGUE` collects them; a new effect also needs a C function in `fmu_build/`.
"""
