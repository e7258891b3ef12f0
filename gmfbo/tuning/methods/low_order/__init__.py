"""A plant of low order, identified from the runs so far, under the controller that the twin has.

`control_law.ControlLaw` reads the controller out of runs at known gains, `closed_loop.simulate` puts
a `closed_loop.PlantModel` under it, and `identification.identify` fits that model to real runs.
"""
