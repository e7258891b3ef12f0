"""Commands that diagnose a digital twin: check, diagnose, experiment, compensate.

Each module holds one command; `diagnose.diagnose_and_show` also serves the demo.
"""
