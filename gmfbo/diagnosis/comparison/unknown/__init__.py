"""What no law of the library holds: a free function of the states at a port.

`kinds` makes the functions, `fitted` fits a row with one of them through the simulators, and
`beside` compares such rows with those of laws alone: what is told to be unknown, and which laws
stand beside it.
"""
