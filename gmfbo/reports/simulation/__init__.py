"""A recording beside the simulation of it, as one page that needs no network.

`page.simulation_page` writes it: recorded, simulated and what is left, for each compared signal.
"""
