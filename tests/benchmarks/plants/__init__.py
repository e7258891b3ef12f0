"""Benchmark of plants: tuning methods on eleven plants, each with a truth that its twin does not know.

`catalogue.py` lists the plants, `run.py` makes studies, `table.py` prints what they came to; the
README tells how a plant is made.
"""
