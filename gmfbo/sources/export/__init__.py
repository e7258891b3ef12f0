"""Export the augmented twin as one FMU that runs in any FMI tool without Python.

`export.export_augmented` writes it, with each `export.PhysicsParameter` as a variable of its own.
"""
