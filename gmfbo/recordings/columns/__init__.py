"""Turn a file's columns into signals in SI units with one common clock.

`interpretation.interpreted` gives the fields of a recording from `columns.RecordedColumns`, by a
`column_mapping.ColumnMapping` and a `signal.SignalSpec` for each signal.
`channels.RecordedChannels` have a clock each.
"""
