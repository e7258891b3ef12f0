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
"""
