"""The tuning loop: ask for gains, tell what came of them, or run it all.

`tuner.Tuner` is the loop over a `study` with its `study_file`; `proposals.Proposals` decides what
is queried next. `methods` holds the tuning methods, `method` is the interface of your own, and
`watch` reports progress.
"""
