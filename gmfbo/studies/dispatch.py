"""Dispatch units to an engine, such that the failure of one does not end the others."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from dataclasses import dataclass, field

from gmfbo.studies.engine import Engine
from gmfbo.studies.unit import Failed, Made, Missing, Result, Unit

ATTEMPTS = 3
"""Lost workers after which a unit is given up."""

PATIENCE_S = 600.0
"""[s] A unit that takes longer, and ten times as long as any that finished, is sent once more:
an executor may lose a unit without a word."""

_LOOK_EVERY_S = 5.0

Finished = Callable[[Unit, Made | Failed], None]


@dataclass(eq=False)
class _Sent:
    unit: Unit
    contents: Mapping[str, bytes] = field(default_factory=dict)
    lost: int = 0
    at: float = 0.0
    overdue: bool = False


class Dispatch:
    """Hands out units and gathers their results, each once.

    Parameters
    ----------
    engine : Engine
        Runs the units.
    contents : mapping of str to bytes
        All files by hash; a file is sent to a worker that reports it missing.
    finished : callable
        Called with each unit and its result, or the reason of its failure.

    Attributes
    ----------
    contents_sent : int
        [byte] Size of the files sent to workers so far.
    """

    def __init__(self, engine: Engine, contents: Mapping[str, bytes], finished: Finished) -> None:
        self._engine, self._contents, self._finished = engine, contents, finished
        self._under_way: dict[Future[Result], _Sent] = {}
        self._waiting: deque[_Sent] = deque()
        self._suspects: deque[_Sent] = deque()
        self._done: set[str] = set()
        self._longest_s = 0.0
        self.contents_sent = 0

    def run(self, units: Iterable[Unit]) -> None:
        """Run all units, in order, as many at a time as there are workers.

        Parameters
        ----------
        units : iterable of Unit
            Each with a label of its own.

        Raises
        ------
        SimulationError
            The engine broke and cannot be renewed.
        """
        self._waiting.extend(_Sent(unit) for unit in units)
        try:
            while self._waiting or self._suspects or self._under_way:
                self._hand_out()
                done = wait(self._under_way, _LOOK_EVERY_S, return_when=FIRST_COMPLETED).done
                broken = [self._settle(future) for future in done]
                if any(broken):
                    self._give_up_on_all()
                    self._engine.renew()
                self._send_overdue_again()
        except BaseException:
            for future in self._under_way:
                future.cancel()
            self._engine.stop()
            raise

    def _hand_out(self) -> None:
        if self._suspects:
            # One at a time, to identify the unit that ends its process.
            if not self._under_way:
                self._send(self._suspects.popleft())
            return
        # No more units than workers: a unit that waits inside an executor cannot be recalled.
        while self._waiting and self._busy < self._engine.workers:
            sent = self._waiting.popleft()
            if sent.unit.label not in self._done and not self._send(sent):
                return

    @property
    def _busy(self) -> int:
        return sum(not sent.overdue for sent in self._under_way.values())

    def _send(self, sent: _Sent) -> bool:
        sent.at = time.monotonic()
        try:
            future = self._engine.submit(sent.unit, sent.contents)
        except BrokenExecutor:
            self._lose(sent)
            self._give_up_on_all()
            self._engine.renew()
            return False
        self._under_way[future] = sent
        return True

    def _settle(self, future: Future[Result]) -> bool:
        """Take the result of a unit; returns whether the engine broke."""
        sent = self._under_way.pop(future, None)
        if sent is None:
            return False  # a copy of a unit that has finished meanwhile
        try:
            result = future.result()
        except BrokenExecutor:
            self._lose(sent)
            return True
        except Exception as error:  # executors differ in the exception for a lost worker
            self._lose(sent, " ".join(f"{error!r}".split()))
            return False
        if isinstance(result, Missing):
            needed = {digest: self._contents[digest] for digest in sorted(result.hashes)}
            self.contents_sent += sum(map(len, needed.values()))
            alone = self._engine.dies_whole and sent.lost > 0
            queue = self._suspects if alone else self._waiting
            queue.appendleft(_Sent(sent.unit, needed, sent.lost))
            return False
        self._longest_s = max(self._longest_s, time.monotonic() - sent.at)
        self._finish(sent.unit, result)
        return False

    def _finish(self, unit: Unit, result: Made | Failed) -> None:
        self._done.add(unit.label)
        for future, sent in list(self._under_way.items()):
            if sent.unit.label == unit.label:  # a copy, or a unit that seemed lost
                future.cancel()
                del self._under_way[future]
        self._finished(unit, result)

    def _lose(self, sent: _Sent, why: str = "") -> None:
        again = _Sent(sent.unit, sent.contents, sent.lost + 1)
        alone = self._engine.dies_whole and sent.lost > 0
        if alone or again.lost >= ATTEMPTS:
            reason = why or "its process was ended from outside; is the memory used up?"
            self._finish(sent.unit, Failed(reason))
        elif self._engine.dies_whole:
            self._suspects.append(again)
        else:
            self._waiting.append(again)

    def _give_up_on_all(self) -> None:
        """Mark all running units as lost with the engine."""
        for sent in list(self._under_way.values()):
            self._lose(sent)
        self._under_way.clear()

    def _send_overdue_again(self) -> None:
        if self._engine.dies_whole:
            return
        limit = time.monotonic() - max(PATIENCE_S, 10.0 * self._longest_s)
        for sent in list(self._under_way.values()):
            if sent.at < limit and not sent.overdue:
                sent.at, sent.overdue = time.monotonic(), True
                self._waiting.append(_Sent(sent.unit, sent.contents, sent.lost))
