"""Locate the mismatch: part of the loop, state in which it acts, and times.

`mismatch_place.locate` says where and when; `parities.parities` checks controller, plant and
transmission each by themselves; `held_twin.hold` makes the twin follow its recordings.
"""
