"""Noise that the controller read.

`sensed_noise` tells it by what a fit leaves, and draws what is not known of it.
"""
