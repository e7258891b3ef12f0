"""Plants as information sources: a Python function, a program, or recorded runs.

`source.Source` is what each source can do. `plant_call.PythonPlant` calls a function,
`plant_command.CommandPlant` a program, and `recorded_grid.RecordedGrid` replays measured runs;
`failed_run.failed_run` is the result of a run that failed.
"""
