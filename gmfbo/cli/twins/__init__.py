"""Commands about twins and recordings: build, import, inspect, columns, simulate.

Each module holds one command; `many_values.ManyValuesCommand` takes several files after one flag.
"""
