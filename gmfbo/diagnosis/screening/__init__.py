"""Screen effects cheaply by the response of the loop to what a port could add.

`port_response.measure_port_response` measures that response once. `probes.screen` ranks the
`testable_effects.candidates` by the chi2 that each would remove, and
`repeating_and_passing.find_lines` does so for periodic disturbances and pulses.
`searched_lines.SearchedLines` keeps what was found last.
"""
