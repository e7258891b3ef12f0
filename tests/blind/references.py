"""What the axes are asked to follow: references that begin and end at zero, at rest."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from tests.blind.truth import SAMPLE, Vector

QUIET = 120
"""Samples at zero before the motion."""

Rng = np.random.Generator


def multisine(rng: Rng, rows: int) -> Vector:
    """Sixteen lines from 0.3 to 25 Hz, accelerations alike, random phases; at most 1."""
    t = np.arange(rows) * SAMPLE
    lines = np.geomspace(0.3, 25.0, 16) * rng.uniform(0.95, 1.05, 16)
    size = 1.0 / (1.0 + (lines / 1.5) ** 2)
    phase = rng.uniform(0.0, 2.0 * np.pi, 16)
    wave = (size[:, None] * np.sin(2.0 * np.pi * lines[:, None] * t + phase[:, None])).sum(axis=0)
    return _unit(wave * _window(rows))


def moves(rng: Rng, rows: int) -> Vector:
    """Point to point with least jerk, pauses between, and back."""
    stops = [0.0, *rng.uniform(-1.0, 1.0, 4), 0.0]
    wave, at, length = np.zeros(rows), QUIET, (rows - QUIET) // 5
    for begin, end in pairwise(stops):
        ramp = int(length * rng.uniform(0.5, 0.9))
        s = np.clip(np.arange(rows - at) / ramp, 0.0, 1.0)
        wave[at:] = begin + (end - begin) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        at += length
    return _unit(wave)


def one_way_moves(rng: Rng, rows: int) -> Vector:
    """Point to point with least jerk, never back."""
    stops = np.concatenate([[0.0], np.cumsum(rng.uniform(0.3, 1.0, 3))])
    wave, at, length = np.zeros(rows), QUIET, (rows - QUIET) // 3
    for begin, end in pairwise(stops):
        ramp = int(length * rng.uniform(0.6, 0.9))
        s = np.clip(np.arange(rows - at) / ramp, 0.0, 1.0)
        wave[at:] = begin + (end - begin) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        at += length
    return np.asarray(_unit(wave) * rng.choice([-1.0, 1.0]))


def triangle(rng: Rng, rows: int) -> Vector:
    """Slow ramps with rounded reversals, of different strokes."""
    corners = np.array([0.0, 1.0, -0.6, 0.5, -1.0, 0.0]) * rng.choice([-1.0, 1.0])
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)))])
    path = np.linspace(0.0, travel[-1], rows - 2 * QUIET)
    wave = np.concatenate([np.zeros(QUIET), np.interp(path, travel, corners), np.zeros(QUIET)])
    return _rounded(wave, 40)


def chirp(rng: Rng, rows: int) -> Vector:
    """From 0.5 to 25 Hz, of an amplitude that falls with the frequency."""
    t = np.arange(rows) * SAMPLE
    end = rng.uniform(18.0, 25.0)
    rate = np.log(end / 0.5) / t[-1]
    frequency = 0.5 * np.exp(rate * t)
    wave = np.sin(2.0 * np.pi * (frequency - 0.5) / rate) / (1.0 + (frequency / 4.0) ** 1.5)
    return _unit(wave * _window(rows))


def steps(rng: Rng, rows: int) -> Vector:
    """Steps of different sizes, and back."""
    at = np.linspace(QUIET, rows, 6, dtype=int)[:-1]
    levels = [*rng.uniform(0.3, 1.0, 4) * np.array([1.0, -1.0, 1.0, -1.0]), 0.0]
    wave = np.zeros(rows)
    for start, level in zip(at, levels, strict=True):
        wave[start:] = level
    return wave


SHAPES: dict[str, Callable[[Rng, int], Vector]] = {
    "multisine": multisine,
    "moves": moves,
    "triangle": triangle,
    "chirp": chirp,
    "steps": steps,
}


def _window(rows: int) -> Vector:
    """Zero at first, then raised to one and down again over a quarter second each."""
    window = np.ones(rows)
    rise = 0.5 - 0.5 * np.cos(np.pi * np.arange(250) / 250)
    window[:QUIET] = 0.0
    window[QUIET : QUIET + 250] = rise
    window[-250:] = rise[::-1]
    return window


def _unit(wave: Vector) -> Vector:
    return np.asarray(wave / np.max(np.abs(wave)))


def _rounded(wave: Vector, samples: int) -> Vector:
    padded = np.pad(wave, samples, mode="edge")
    kernel = np.hanning(samples)
    return np.convolve(padded, kernel / kernel.sum(), mode="same")[samples:-samples]
