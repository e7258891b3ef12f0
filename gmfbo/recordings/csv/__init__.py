"""Read text: our own CSV, and what loggers, oscilloscopes, spreadsheets write.

`table.read_csv` reads a file: `cells.separator_of_table`, `preamble.header_row` and
`layout.layout_of` find its parts, `header.split_unit` parts name and unit of a column.
`lvm.read_lvm` and `twincat_scope.read_scope` read formats with a header of their own.
"""
