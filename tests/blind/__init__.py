"""Plants of the diagnosis' benchmark: hidden physics, recordings, answers kept apart.

The plants (`truth.c`) share no code with the package: other integrator, other step, hard
stick-slip friction, Hunt-Crossley contact, Maxwell-slip hysteresis with other elements and travels,
delays off the grid, controllers written again from their equations. A test holds each of them
against its twin. `draw` draws cases of them, runs a diagnosis on these and makes the tables.

    FOLDER/cases/003/       twin.toml, rec0.csv ...: all that the diagnosis sees
    FOLDER/answers/003.json what was hidden
    FOLDER/answers.sha256   of every answer, written before its run

The machines: the servo axis with all ports, with the torque port only, and with none; the linear
axis; the motor bench in open loop; and the bench under each of the three controllers, on wires.
Effects that are a parameter elsewhere (viscous friction, load inertia, gain loss, sensor scale) are
hidden in machines whose inertia and viscous friction are measured and fixed in the twin. Each case
has four to six recordings of 2.5 to 4 s at 1 kHz, some at other gains, from an encoder of 65536
counts (1 um on the linear axis) with white noise beside it.

Nulls are plain (in a third of them the twin's parameters are right, in the others, as in all
further cases, inertia is 5-15 % and viscous friction 5-30 % off) or stressed (current lag -20 to
+30 %, drive gain 1-2 % off, command column 3 % off, logger of the other convention, clock
100-200 ppm off, coloured noise); `draw` has more kinds. A decoy is an effect in plant and twin
alike, one that these motions do not excite, or one that is a parameter.

Sizes are those at which the oracle (`oracle.py`: a refit with the truth itself) gains what was
drawn, log-uniform (`sizing.py`). A sensor offset cannot be seen on these machines: none of them has
an absolute place. Gain loss and sensor scale are the same to one encoder and one command: a set is
their best answer. Periodic and passing disturbances keep the time of the recording's start; ripple
is a share of the motor's signed torque.
"""
