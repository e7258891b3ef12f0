"""Real runs that a person makes: asked for as files, told as recordings.

`next_run.write_next_run` asks, `told_series.read_told` reads what comes back, and
`told_gains.told_gains` finds at which gains it was made. `real_axis.RealAxis` turns what cannot
be scored into a failed run, `recorded_choice.RecordedChoice` chooses among recorded runs, and
`earlier_runs.EarlierRuns` takes over the real runs of an earlier study.
"""
