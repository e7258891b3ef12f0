"""Simulate the augmented twin along all recordings, several runs at a time."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.fitted_start import FittedStart
from gmfbo.diagnosis.runs.scored_record import Record, means_over_rows
from gmfbo.diagnosis.runs.simulated import (
    PlayedNoise,
    Point,
    Reading,
    Simulated,
    Tracking,
    changes,
)
from gmfbo.diagnosis.runs.twin_steps import inputs_unstated
from gmfbo.physics import CATALOGUE
from gmfbo.sources.twin.augmented_twin import AugmentedTwin, RunPlan
from gmfbo.sources.twin.response import Columns, Response

REMEMBERED = 256 * 2**20
"""[B] Kept responses, of failed runs too, since screening, starts and fits share points."""

_COLUMNS = 12  # about as many columns as a response has

Task = TypeVar("Task")
Made = TypeVar("Made")


@dataclass(frozen=True)
class _Run:
    """Key of a kept response: all that decides it."""

    plan: RunPlan
    record: int
    values: tuple[tuple[str, float], ...]
    physics: tuple[tuple[str, float], ...]
    tracking: Tracking | None
    noise: PlayedNoise | None = None


class Simulations:
    """Simulators of one twin and the recordings that they follow.

    Each of `jobs` simulators runs the FMUs in a process of its own; this process hands out orders,
    and computes with some answers while it waits for others. Recent responses are kept and reused.

    Parameters
    ----------
    open_twin : callable
        Opens a simulator; called once for each.
    records : sequence of Record
        Recordings along which the twin runs.
    jobs : int
        Simulators that run at a time.

    Attributes
    ----------
    rest : int
        Communication steps until the loop is at rest; 0 where it does not come to rest.
    finer : callable () -> Simulations, or None
        Opens simulators of the same recordings at half the step, where the twin takes it.
    starts : tuple of FittedStart
        Starts of the axis that are fitted to each recording.
    unstated : frozenset of str
        Inputs of which the twin file does not say what they do between their rows.
    begins_at_rest : bool
        Whether the left-out physics already acted before the recording, so that the first
        reference is held for `rest` steps; otherwise the physics begins with the recording.
    """

    def __init__(
        self, open_twin: Callable[[], AugmentedTwin], records: Sequence[Record], jobs: int
    ) -> None:
        self.records = tuple(records)
        self.rest = 0
        self.begins_at_rest = True
        self.starts: tuple[FittedStart, ...] = ()
        self.new_rows: frozenset[str] = frozenset()
        self.tracking: Tracking | None = None
        self.encoder: Reading | None = None
        self.reading: Reading | None = None
        self._simulators: queue.SimpleQueue[AugmentedTwin] = queue.SimpleQueue()
        self._all = [open_twin() for _ in range(jobs)]
        for simulator in self._all:
            self._simulators.put(simulator)
        self._threads = ThreadPoolExecutor(jobs)
        self._lock = threading.Lock()
        rows = max(record.plan.grid.size for record in self.records)
        self._remembered = lru_cache(REMEMBERED // (8 * _COLUMNS * rows))(self._simulate)
        self._after_rest = cache(RunPlan.led_by)
        self.runs = 0
        self.unstated = inputs_unstated(self._all[0].twin)
        self.finer: Callable[[], Simulations] | None = None
        self._half_step: Simulations | None = None
        self.on_run: Callable[[], None] = lambda: None

    @property
    def half_step(self) -> Simulations | None:
        """The same at half the step, opened when it is first asked for; None without `finer`."""
        if self._half_step is None and self.finer is not None:
            self._half_step = self.finer()
            self._half_step.on_run = self._count
        if (finer := self._half_step) is not None:
            finer.rest, finer.begins_at_rest = self.rest, self.begins_at_rest
            finer.new_rows, finer.tracking = self.new_rows, self.tracking
            finer.encoder, finer.reading = self.encoder, self.reading
            finer.starts = self.starts
            if finer.reading is not None:
                finer.reading = replace(finer.reading, late=0.5 * finer.reading.late)
            both = zip(self.records, (record.plan for record in finer.records), strict=True)
            finer.replace_records(
                [replace(own, plan=plan.led_by(own.plan.lead)) for own, plan in both]
            )
        return self._half_step

    def step_errors(
        self, point: Point, runs: Sequence[Simulated]
    ) -> list[tuple[NDArray[np.float64], ...] | None]:
        """[SI] Change of each recording's signals at half the step; None where it is not known.

        Parameters
        ----------
        point : Point
            Values at which the twin runs.
        runs : sequence of Simulated
            The recordings there.
        """
        finer = self.half_step
        if finer is None:
            return [None] * len(runs)
        return changes(runs, finer.run([point])[0])

    def input_errors(
        self, point: Point, runs: Sequence[Simulated]
    ) -> list[tuple[NDArray[np.float64], ...] | None]:
        """[SI] Change of each recording's signals by what its inputs do between their rows.

        A controller that is faster than its logger sees a smooth reference; held from row to row,
        it gives the twin's command a kick at each. The change is that of inputs which go straight
        from row to row.

        Parameters
        ----------
        point : Point
            Values at which the twin runs.
        runs : sequence of Simulated
            The recordings there.
        """
        if not self.unstated or self.tracking is not None:
            return [None] * len(runs)
        return changes(runs, self.map(lambda k: self._run_straight(point, k), range(len(runs))))

    def averaged(self, run: Simulated, record: int) -> tuple[NDArray[np.float64], ...]:
        """[SI] Scored signals of a run as a logger stores them that averages over its rows.

        Parameters
        ----------
        run : Simulated
            Of a recording.
        record : int
            Its index.
        """
        own, means = self.records[record], run.response.mean
        return tuple(means_over_rows(own.plan, means[s.name], s.time) for s in own.signals)

    def _run_straight(self, point: Point, record: int) -> Simulated:
        run = self._ordered(point, record, self.tracking)
        response = self._simulate(replace(run, plan=run.plan.straight(self.unstated)))
        return self._seen(response, record, {})

    @property
    def settings(self) -> dict[str, float]:
        """Settings of physics.fmu that follow from the twin."""
        return self._all[0].settings

    def run(self, points: Sequence[Point]) -> list[list[Simulated]]:
        """Simulate all recordings at each point.

        Parameters
        ----------
        points : sequence of Point
            Where to simulate.
        """
        orders = [(point, k) for point in points for k in range(len(self.records))]
        done = list(self._threads.map(lambda order: self.run_one(*order), orders))
        width = len(self.records)
        return [done[i * width : (i + 1) * width] for i in range(len(points))]

    def run_here(self, point: Point) -> list[Simulated]:
        """Simulate all recordings at one point, one after the other, on the calling thread."""
        return [self.run_one(point, k) for k in range(len(self.records))]

    def run_one(
        self,
        point: Point,
        record: int,
        *,
        excitation: Columns | None = None,
        measured_noise: NDArray[np.float64] | None = None,
        acts_at_rest: bool = False,
    ) -> Simulated:
        """Simulate one recording.

        Parameters
        ----------
        point : Point
            Values at which the twin runs.
        record : int
            Index of the recording.
        excitation : mapping of str to ndarray, shape (rows,)
            [FMU's unit] Added to a port, in place of noise that the point plays.
        measured_noise : ndarray, shape (rows,)
            [FMU's unit] Added to the position that the tracking loop follows.
        acts_at_rest : bool
            What is added at a port stands for physics that acted before the recording.
        """
        noise = None if point.noise is None or excitation is not None else point.noise[record]
        if noise is None:
            tracking = self.tracking
            return self._run(
                point, record, excitation, measured_noise, tracking, acts_at_rest=acts_at_rest
            )
        noisy = self._run(point, record, None, measured_noise, self.tracking, noise)
        signals = zip(noisy.signals, noise.linear, strict=True)
        return replace(noisy, signals=tuple(column - linear for column, linear in signals))

    def run_freely(self, point: Point, record: int) -> Simulated:
        """Simulate one recording of an open-loop twin with nothing that keeps it near.

        Parameters
        ----------
        point : Point
            Values at which the twin runs.
        record : int
            Index of the recording.
        """
        return self._run(point, record, None, None, None)

    def _run(
        self,
        point: Point,
        record: int,
        excitation: Columns | None,
        measured_noise: NDArray[np.float64] | None,
        tracking: Tracking | None,
        noise: PlayedNoise | None = None,
        acts_at_rest: bool = False,
    ) -> Simulated:
        run = replace(self._ordered(point, record, tracking, acts_at_rest), noise=noise)
        if excitation is None and measured_noise is None:
            pushed = {} if noise is None else {noise.port: noise.at_port}
            return self._seen(self._remembered(run), record, pushed)
        response = self._simulate(run, excitation, measured_noise)
        return self._seen(response, record, excitation or {})

    def _ordered(
        self, point: Point, record: int, tracking: Tracking | None, acts_at_rest: bool = False
    ) -> _Run:
        physics = point.physics_in(record)
        values = tuple(self._parameters(point, record).items())
        plan = self._plan(record, physics, acts_at_rest)
        return _Run(plan, record, values, tuple(physics.items()), tracking)

    def _parameters(self, point: Point, record: int) -> dict[str, float]:
        starts = {start.name: start.values[record] for start in self.starts}
        return {**starts, **point.parameters_in(record)}

    def _seen(self, response: Response, record: int, pushed: Columns) -> Simulated:
        if self.reading is not None:
            response = self.reading.logged(response, pushed.get("sensor", 0.0))
        return Simulated(self.read(response, record), response)

    def _plan(self, record: int, physics: Mapping[str, float], acts_at_rest: bool) -> RunPlan:
        plan = self.records[record].plan
        if not self.begins_at_rest or plan.lead >= self.rest:
            return plan
        acting = (CATALOGUE[name.partition(".")[0]].acts_at_rest for name in physics)
        if not acts_at_rest and not any(acting):
            return plan
        return self._after_rest(plan, self.rest)

    def _simulate(
        self,
        run: _Run,
        excitation: Columns | None = None,
        measured_noise: NDArray[np.float64] | None = None,
    ) -> Response:
        physics, measured = dict(run.physics), None
        if run.noise is not None:
            excitation = {run.noise.port: run.noise.at_port}
        if run.tracking is not None:
            physics = {**run.tracking.settings, **physics}
            measured = run.tracking.measured[run.record]
            if measured_noise is not None:
                measured = measured + measured_noise
        with self._simulator() as simulator:
            return simulator.run(
                run.plan, dict(run.values), physics, excitation=excitation, measured=measured
            )

    def run_parity(
        self,
        point: Point,
        record: int,
        settings: Mapping[str, float],
        measured: NDArray[np.float64],
        held: Mapping[str, float] | None = None,
    ) -> Response:
        """Simulate one recording while loops of physics.fmu hold the twin on it.

        Parameters
        ----------
        point : Point
            Values at which the twin runs.
        record : int
            Index of the recording.
        settings : mapping of str to float
            Of the loops.
        measured : ndarray, shape (rows,)
            [FMU's unit] Recorded position.
        held : mapping of str to float, optional
            [FMU's unit] FMU inputs that nothing drives, and the value of each.
        """
        physics = {**settings, **point.physics_in(record)}
        plan = self.records[record].plan
        with self._simulator() as simulator:
            values = self._parameters(point, record)
            return simulator.run(plan, values, physics, measured=measured, held=held)

    def read(self, response: Response, record: int) -> tuple[NDArray[np.float64], ...]:
        """Scored signals of a response at their own times."""
        columns = []
        for signal in self.records[record].signals:
            if signal.name in self.new_rows:
                source = response.new[signal.name]
            else:
                source = response.held[signal.name]
            columns.append(self.records[record].plan.at(source, signal.time))
        return tuple(columns)

    def map(self, work: Callable[[Task], Made], tasks: Iterable[Task]) -> list[Made]:
        """Apply work that uses `run_here` or `run_one`, several tasks at a time."""
        return list(self._threads.map(work, tasks))

    def side_by_side(self, work: Callable[[Task], Made], tasks: Iterable[Task]) -> list[Made]:
        """Apply work that uses `run`, as many tasks at a time as there are simulators.

        While one waits for its simulations, another computes.
        """
        if len(self._all) == 1:
            return [work(task) for task in tasks]
        with ThreadPoolExecutor(len(self._all)) as threads:
            return list(threads.map(work, tasks))

    def replace_records(self, records: Sequence[Record]) -> None:
        """Score other signals of the same recordings."""
        self.records = tuple(records)

    def close(self) -> None:
        """End all processes."""
        if self._half_step is not None:
            self._half_step.close()
        self._threads.shutdown(wait=True, cancel_futures=True)
        self._remembered.cache_clear()
        for simulator in self._all:
            simulator.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @contextmanager
    def _simulator(self) -> Iterator[AugmentedTwin]:
        simulator = self._simulators.get()
        try:
            yield simulator
        finally:
            self._simulators.put(simulator)
            self._count()

    def _count(self) -> None:
        with self._lock:
            self.runs += 1
        self.on_run()
