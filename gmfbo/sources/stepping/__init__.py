"""Load FMUs of FMI 2.0 and 3.0 and step them over arrays, in C or in Python.

`simulator.Simulator` runs jobs; all else here serves it.
"""
