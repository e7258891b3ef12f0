"""Turn diagnosed effects into tables or code by which a drive cancels them.

`compensation.compensation_of` makes the laws from a diagnosis; `text.csv_text`, `text.c_text`,
`structured_text.structured_text` and `text.formula` write them, and `text.target_words` names the
signal to which each is added.
"""
