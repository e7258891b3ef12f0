"""A periodic disturbance: a neighbouring machine, at a fixed frequency."""

import math

import numpy as np

from gmfbo.physics.effect import Effect, EffectParameter, Units, Values, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.harmonic import amplitude
from gmfbo.physics.states import Array, States
from gmfbo.units import quantity


def _signal(states: States, parameters: Values) -> Array:
    phase = 2.0 * math.pi * parameters["frequency"] * states.time
    return np.asarray(parameters["sine"] * np.sin(phase) + parameters["cosine"] * np.cos(phase))


def _frequencies(excitation: Excitation) -> tuple[float, ...]:
    # Where no line was found: ten cycles, at which a detectable size is stated.
    return excitation.frequencies[:4] or (min(10.0 / excitation.duration, 0.1 / excitation.sample),)


def _starts(excitation: Excitation) -> list[Values]:
    size = 0.05 * excitation.torque
    return [{"frequency": f, "sine": size, "cosine": size} for f in _frequencies(excitation)]


def _statement(parameters: Values, units: Units, place: str) -> str:
    size = quantity(amplitude(parameters), units.torque)
    frequency = quantity(parameters["frequency"], "Hz")
    return (
        f"A periodic {units.torque_word} of about {size} at {frequency} {place} "
        "is missing from the twin."
    )


periodic_disturbance = Effect(
    name="periodic_disturbance",
    port="torque",
    family="disturbance",
    signal_path="plant",
    parameters=(
        signed("sine", "Sine amplitude", "torque", lambda e: e.torque),
        signed("cosine", "Cosine amplitude", "torque", lambda e: e.torque),
        EffectParameter(
            "frequency",
            "Frequency",
            "Hz",
            low=lambda e: 0.5 * min(0.5 / e.duration, *_frequencies(e)),
            high=lambda e: 2.0 * max(0.25 / e.sample, *_frequencies(e)),
            # One radian of phase over the recording.
            scale=lambda e: 1.0 / (2.0 * math.pi * e.duration),
        ),
    ),
    starts=_starts,
    size=lambda p, e: amplitude(p),
    size_name="amplitude",
    size_unit="torque",
    floor=lambda e: 1.5e-4 * e.torque,
    signal=_signal,
    acts_at_rest=True,
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: f"at all times, {quantity(p['frequency'], 'Hz')} in time",
    region_state="time",
    statement=_statement,
    equation="tau = A * sin(2 * pi * f * t) + B * cos(2 * pi * f * t)",
    source="Fourier, 1822",
    confused_with={
        "cogging_torque": "two speeds: cogging stays fixed to the position",
        "torsional_compliance": "standstill: a disturbance goes on, a resonance dies out",
    },
)
