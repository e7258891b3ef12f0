"""Information sources: plants and digital twins that can run an experiment.

`plants` holds the interface `plants.source` and plants that are programs or functions. A twin is
read (`twin_file`), joined to its FMUs (`fmu_file`, `binding`) and run (`twin`) by a `worker` in a
`sandbox` (`stepping`). `inspection` looks at unknown FMUs, and `export` writes augmented ones.
"""
