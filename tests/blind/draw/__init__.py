"""A stratified draw of cases by which every version of the diagnosis is compared.

The plants, references, sizes and answers are those of `tests.blind`; what is new here are seven
kinds of nulls, laws outside the library beside the first eleven, and a table of them all. Each
step can be stopped and called again:

    python -m tests.blind.draw.generate --out FOLDER [--jobs 2]            # development, 100 cases
    python -m tests.blind.draw.generate --registered --seed N --out FOLDER # 700 cases
    python -m tests.blind.draw.run --out FOLDER --to OUTCOMES.jsonl [--jobs 2] [--strata null owed]
    python -m tests.blind.draw.table OUTCOMES.jsonl [MORE.jsonl ...] [--text FILE]
    python -m tests.blind.draw.against_the_true_law OUTCOMES.jsonl --seed N --to RESULT.jsonl

    FOLDER/cases/003/       twin.toml, rec0.csv ...: all that the diagnosis sees
    FOLDER/answers/003.json what was hidden; FOLDER/answers.sha256 the hash of each
    OUTCOMES.jsonl          a line a case: what was said, beside what was hidden

Kinds of nulls; in all of them the twin's inertia and viscous friction are 5 to 30 % off, as in the
blind benchmark, unless said otherwise:

old          plain and stressed nulls of the blind benchmark
logger       white noise, or coarse counts, in the logged columns only
timing       logged at instants that jitter, or behind a low pass, without a word about it
parameters   fifteen uncertain parameters, or one that the recordings cannot tell from others
fixed        a fixed parameter is 1.3 to 2 times what the twin says: "NAME" or nothing is right
loop         coloured torque noise at the shaft, or a controller four times as fast as its logger
simulator    MuJoCo plays the plant, certified equal to the twin within a quarter of the noise
"""
