"""Run the augmented twin along recordings, and read these as scored signals.

`simulations.Simulations` runs a `simulated.Point` of the twin and gives a `simulated.Simulated`
for each `scored_record.Record`. `measured_excitation.states_of` and
`measured_excitation.measure_ranges` tell how the axis moved; `probing_torque.torque_guess` the
size of torque that suits it; `logging_convention.logged_new` how the command was logged.
"""
