"""Read CSV: our own format, and what loggers and spreadsheets write.

`table.read_csv` finds where the table begins, its separators and its decimal sign;
`header.split_unit` parts name and unit of a column.
"""
