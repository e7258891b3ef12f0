"""Screen effects cheaply by the response of the loop to what a port could add.

`port_response.measure_port_response` measures that response once. `probes.screened` tells how
far recordings show one of the `testable_effects.candidates` beside what parameters make, and
`repeating_and_passing.find_lines` ranks periodic disturbances and pulses by what each would remove.
`searched_lines.SearchedLines` keeps what was found last.
"""
