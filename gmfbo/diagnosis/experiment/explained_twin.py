"""Simulate explanations of an earlier diagnosis along other recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis, Setting
from gmfbo.diagnosis.naming.open_explanations import as_candidate
from gmfbo.diagnosis.result.findings import Findings
from gmfbo.diagnosis.result.predictions import Explanation, Predictions
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.uncertain import Uncertain, uncertain_of


def saved_predictions(diagnosis: Findings) -> Predictions:
    """Explanations of an earlier diagnosis.

    Raises
    ------
    InputError
        It is of a version that saved none.
    """
    if diagnosis.predictions is None:
        raise InputError(
            "expected a diagnosis that holds 'predictions', which this older one does not; "
            "diagnose again"
        )
    return diagnosis.predictions


def fitted_as_saved(explanation: Explanation, setting: Setting, twin: FmuTwin) -> Fitted:
    """Hypothesis at exactly the values of an explanation; nothing is simulated.

    Parameters
    ----------
    explanation : Explanation
        Of an earlier diagnosis.
    setting : Setting
        Of the recordings that are simulated now.
    twin : FmuTwin
        The same twin as then.

    Raises
    ------
    InputError
        The explanation is of another twin, or of a later version.
    """
    check_known(explanation, twin)
    effects = tuple(
        as_candidate(name, explanation.physics)
        for name in explanation.effects
        if any(key.startswith(f"{name}.") for key in explanation.physics)
    )
    uncertain = uncertain_of(twin)
    known = {u.name for u in uncertain}
    freed = [
        Uncertain(
            name, twin.nominal(name), min(value, twin.nominal(name)), max(value, twin.nominal(name))
        )
        for name, value in explanation.parameters.items()
        if name not in known
    ]
    hypothesis = Hypothesis(replace(setting, uncertain=(*uncertain, *freed)), effects)
    values = [explanation.parameters.get(u.name, u.nominal) for u in hypothesis.setting.uncertain]
    for candidate in effects:
        values += [candidate.values[p.name] for p in candidate.parameters]
    return Fitted(hypothesis, np.array(values, dtype=np.float64), [], (), (), [])


def check_known(explanation: Explanation, twin: FmuTwin) -> None:
    """Raise unless this twin can be simulated under an explanation.

    Raises
    ------
    InputError
        A parameter or an effect is unknown here.
    """
    for name in explanation.parameters:
        if name not in twin.binding.parameters:
            raise InputError(
                f"the diagnosis is of another twin than {twin.name}: expected a parameter "
                f"'{name}'; give the twin file that was diagnosed"
            )
    for name in explanation.effects:
        if name not in CATALOGUE:
            raise InputError(
                f"the diagnosis names '{name}', which this version does not know; diagnose again"
            )


def points_of(
    explanations: Sequence[Explanation], setting: Setting, twin: FmuTwin
) -> dict[str, Point]:
    """Values of twin and physics under each explanation, by its name.

    Parameters
    ----------
    explanations : sequence of Explanation
        Of an earlier diagnosis.
    setting : Setting
        Of the recordings that are simulated now.
    twin : FmuTwin
        The same twin as then.
    """
    points = {}
    for explanation in explanations:
        fitted = fitted_as_saved(explanation, setting, twin)
        points[explanation.name] = fitted.hypothesis.point(fitted.x)
    return points
