"""Screen effects cheaply by the response of the loop to what a port could add.

`port_response.measure_port_response` measures that response once. `testable_effects.candidates`
are the effects at their starts, and `repeating_and_passing.find_lines` ranks periodic disturbances
and pulses by what each would remove. `searched_lines.SearchedLines` keeps what was found last.
"""
