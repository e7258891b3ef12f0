"""A plant of low order from the real runs, under the controller of the twin.

`control_law.ControlLaw` reads the controller out of runs at known gains.
`closed_loop.simulate` puts a `closed_loop.PlantModel` under it, and
`identification.identify` fits that model to real runs.
"""
