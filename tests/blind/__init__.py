"""Blind benchmark of the diagnosis: hidden physics, recordings, answers kept apart, a score.

The plants (`truth.c`) share no code with the package: other integrator, other step, hard
stick-slip friction, Hunt-Crossley contact, Maxwell-slip hysteresis, delays off the grid,
controllers written again from their equations. The library's hysteresis has been Maxwell slip too
since 259b65a, with other elements and travels. A test holds each of them against its twin.

Commands, each of which can be stopped and called again:

    python -m tests.blind.generate --seed 1 --out FOLDER [--cases 510] [--start 100 --count 50]
    python -m tests.blind.run --out FOLDER [--jobs 2] [--only 003 007] [--keep]
    python -m tests.blind.baselines --out FOLDER [--brute 48]
    python -m tests.blind.placebo exclude --out FOLDER --to PLACEBO [--count 24]   # then run it
    python -m tests.blind.outcomes keep FILE --out FOLDER   # and `take` elsewhere
    python -m tests.blind.score --out FOLDER [--placebos PLACEBO ...] [--text FILE]

and without baselines and placebos in a row: `python -m tests.blind --seed 1 --out FOLDER`. Chunks
of one benchmark have the same --cases and --seed. `run` takes what is written and hashed by then.

    FOLDER/cases/003/       twin.toml, rec0.csv ...: all that the diagnosis sees
    FOLDER/answers/003.json what was hidden
    FOLDER/answers.sha256   of every answer, written before its run
    FOLDER/results/003/     what `gmfbo diagnose` left there, its output and its time

Of 510 cases 150 have nothing to name: 50 plain nulls (in a third of them the twin's parameters are
right, in the others inertia is 5-15 % and viscous friction 5-30 % off, as in all further cases);
60 stressed ones (current lag -20 to +30 %, drive gain 1-2 % off, command column 3 % off, logger of
the other convention, clock 100-200 ppm off, coloured noise); 40 decoys (an effect in plant and twin
alike, one that these motions do not excite, one that is a parameter). 260 have one hidden effect:
each of the catalogue's 32 names eight times, and four at a twin without the port for it. 60 have
two effects, 40 a law outside the catalogue, of torque, command or sensor.

The machines: the servo axis with all ports, with the torque port only, and with none; the linear
axis; the motor bench in open loop; and the bench under each of the three controllers, on wires.
Effects that are a parameter elsewhere (viscous friction, load inertia, gain loss, sensor scale) are
hidden in machines whose inertia and viscous friction are measured and fixed in the twin. Each case
has four to six recordings of 2.5 to 4 s at 1 kHz, some at other gains, from an encoder of 65536
counts (1 um on the linear axis) with white noise beside it.

Sizes are those at which the oracle (`oracle.py`: a refit with the truth itself) gains what was
drawn, log-uniform: a third of each name's cases below 15, a third from 15 to 250, a third from 250
to 10,000 (`sizing.py`). A sensor offset cannot be seen on these machines: none of them has an
absolute place, so all its cases lie below. Gain loss and sensor scale are the same to one encoder
and one command: a set is their best answer. Periodic and passing disturbances keep the time of the
recording's start; ripple is a share of the motor's signed torque.
"""
