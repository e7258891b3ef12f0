"""Blind benchmark of the diagnosis: hidden physics, recordings, answers kept apart, a score.

The plants (`truth.c`) share no code with the package: other integrator, other step, hard
stick-slip friction, Hunt-Crossley contact, Maxwell-slip hysteresis, delays off the grid,
controllers written again from their equations. A test holds each of them against its twin.

Three commands, each of which can be stopped and called again:

    python -m tests.blind.generate --cases 20 --seed 1 --out FOLDER   # cases, answers, hashes
    python -m tests.blind.run --out FOLDER [--jobs 2] [--only 003 007]
    python -m tests.blind.score --out FOLDER [--text FILE]

and all of them in a row: `python -m tests.blind --cases 120 --seed 1 --out FOLDER`.

    FOLDER/cases/003/       twin.toml, rec0.csv ...: all that the diagnosis sees
    FOLDER/answers/003.json what was hidden
    FOLDER/answers.sha256   of every answer, written before any run
    FOLDER/results/003/     what `gmfbo diagnose` left there, its output and its time

Of 120 cases 40 are nulls (20 of them stressed: current lag -20 to +30 %, drive gain 1-2 % off,
command column 3 % off, logger of the other convention, clock 100-200 ppm off, coloured noise),
60 have one hidden effect (3 of them at a twin without the port for it), 8 have two, 8 have one
that no catalogue describes, 4 are decoys: something that is there, or in plant and twin alike,
and leaves nothing to name. In every case inertia (5-15 %) and viscous friction (5-30 %) are wrong.

The machines: the servo axis with all ports, with the torque port only, and with none; the linear
axis; the motor bench in open loop; and the bench under each of the three controllers, on wires.
Each has four to six recordings of 2.5 to 4 s at 1 kHz, some at other gains, from an encoder of
65536 counts (1 um on the linear axis) with white noise beside it.

Sizes are drawn by what the oracle could gain (`oracle.py`): a third of the single effects below a
gain of 60, the others from 60 to a million, log-uniform. Periodic and passing disturbances keep
the time of the recording's start; ripple is a share of the motor's signed torque.
"""
