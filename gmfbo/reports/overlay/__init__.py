"""A page that lays simulated trajectories over recorded ones.

`page.overlay_page` draws each compared signal of each recording, with its error.
"""
