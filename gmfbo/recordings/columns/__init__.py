"""Turn a file's columns into signals in SI units with one common clock.

`interpretation.interpreted` makes a recording of `columns.RecordedColumns` by a
`column_mapping.ColumnMapping` and a `signal.SignalSpec` a signal. `channels.RecordedChannels`
have a clock each; `units.parse_unit` reads units as people write them.
"""
