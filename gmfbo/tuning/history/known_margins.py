"""Margins of the loop by gains: measured on the twin once, and logged."""

from __future__ import annotations

from collections.abc import Mapping

from gmfbo.tuning.experiment.loop_margins import MarginMeter, differing
from gmfbo.tuning.history.standing import StandingStore


class KnownMargins:
    """Margins at the gains of a study's runs.

    Parameters
    ----------
    meter : MarginMeter or None
        Measures on the twin; None where no margin is limited.
    store : StandingStore
        Its log gets each measurement.
    """

    def __init__(self, meter: MarginMeter | None, store: StandingStore) -> None:
        self._meter, self._store = meter, store
        self._known: dict[tuple[tuple[str, float], ...], dict[str, float]] = {}

    def at(self, gains: Mapping[str, float]) -> dict[str, float]:
        """Margins at some gains; empty where none is limited.

        Parameters
        ----------
        gains : mapping of str to float
            All gains by name [unit of the FMU parameter].
        """
        if self._meter is None:
            return {}
        key = tuple(sorted(gains.items()))
        if key not in self._known:
            found = self._meter.measure(gains)
            self._known[key] = dict(found.values)
            self._store.log(
                "margins",
                gains=dict(gains),
                amplitudes=list(found.amplitudes),
                each=[dict(one) for one in found.each],
                note="; ".join(differing(found)),
            )
        return dict(self._known[key])
