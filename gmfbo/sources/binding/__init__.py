"""Join a twin file to its FMUs: each name becomes a variable of its kind.

`bind.bind` makes the `binding.Binding`, `augmented_binding.augment` one with physics.fmu at the
ports, and `content_hash.content_hash` a hash of all that decides a run's outcome.
`lookup_table.tables_of` finds tables that are known only roughly.
"""
