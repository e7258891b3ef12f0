"""Write a first twin file from an FMU and logs of its axis, checked by simulation.

`signals.signals_of` names the FMU's signals as loggers do, `log_columns.read_log` finds their
columns, `trial.tried` simulates the logs and settles units that no file states, and
`twin_text.twin_text` writes the file.
"""
