"""Commands about twins and recordings, a file for each.

`column_options` has the options by which a person maps columns,
`init_questions.answered` asks for them at a terminal, `many_values.ManyValuesCommand` takes
several files after one flag.
"""
