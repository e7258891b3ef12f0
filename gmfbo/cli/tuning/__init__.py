"""Commands that tune: a study run, watched, told, reported, repaired or compared.

Each module holds one command; `tune.run_study` also serves the demo.
"""
