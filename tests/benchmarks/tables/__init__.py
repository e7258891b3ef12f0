"""Tables of README and of the benchmarks' pages, written from the results.

`python -m tests.benchmarks.tables` writes them; a test fails where a document holds another one.
"""
