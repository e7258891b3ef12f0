"""Digital twins as information sources, alone or with physics at their ports.

`twin.FmuTwin` runs an experiment, and `augmented_twin.AugmentedTwin` runs along recordings with
physics.fmu beside it. `uncertain.uncertain_of` lists the parameters that the twin file calls
uncertain, and `parameter_values.check_parameters` holds values against the FMU's bounds.
"""
