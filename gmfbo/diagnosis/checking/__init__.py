"""Check recordings before any diagnosis: faults, and the effects they can show.

`check.check` gives a `result.Check` without fitting anything, and `text.check_lines` prints it.
`nominal_case.open_nominal` opens the case, `showable_sizes.showable_sizes` tells how small an
effect would still show, and `shown_gains.find_shown_gain` finds gains that were stated wrongly.
"""
