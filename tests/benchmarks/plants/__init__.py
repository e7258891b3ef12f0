"""Benchmark of plants: tuning methods on eleven plants, of which their twins know only a part.

`catalogue.py` lists the plants, `run.py` makes studies, `table.py` prints what they came to; the
README tells how a plant is made.
"""
