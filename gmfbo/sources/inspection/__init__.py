"""Look at an FMU or SSP package for the first time, and write a twin file for it.

`inspection.inspect_fmu` gives an `fmu_report.FmuReport`, `inspection.try_fmu` takes a few steps,
`inspection.starting_twin_file` writes a twin file to begin with, and `ssp_import.import_ssp`
turns a package into FMUs and a twin file.
"""
