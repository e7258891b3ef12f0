"""Numbers of a study's page, as the JSON embedded in it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import Any

from gmfbo.objective.margins import MARGINS
from gmfbo.objective.metric_words import MetricWords
from gmfbo.objective.mismatch import query_cost, source_lengthscale
from gmfbo.pages.html_page import embedded_json
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.run_roles import Run
from gmfbo.reports.study.study_remarks import study_remarks, unmet_of_recommended
from gmfbo.tuning.history.incumbent import has_settled


def study_content(review: StudyReview) -> dict[str, Any]:
    """Content of a study in numbers and names, without trajectories.

    Returns
    -------
    dict
        JSON values; null stands for a number that is not finite.
    """
    file = review.file
    content: dict[str, Any] = {
        "schema": 1,
        "name": file.name,
        "method": file.method,
        "seed": file.seed,
        "signal": file.objective.signal,
        "weights": dict(file.objective.weights),
        "limits": dict(file.constraints),
        "gains": {
            gain.name: {
                "low": gain.low,
                "high": gain.high,
                "scale": gain.scale,
                "unit": review.gain_unit(gain.name),
            }
            for gain in review.space.gains
        },
        "metrics": {name: review.unit_of(name) for name in review.metrics},
        "from_the_twin": [name for name in review.metrics if name in MARGINS],
        "counts": {source: len(review.of(source)) for source in ("IS1", "IS2", "IS3")},
        "simulated": len(review.of("IS2")) + len(review.of("IS3")),
        "earlier": sum(run.role == "earlier" for run in review.runs),
        "queries": review.runs[-1].query,
        "cost": review.runs[-1].cost,
        "best": review.best.number if review.best else None,
        "first": review.first.number if review.first else None,
        "best_real_run": _place(review),
        "settled": review.settled,
        "ended": review.ended,
        "comparison": _comparison(review),
        "recommendation": _recommendation(review),
        "unmet": list(unmet_of_recommended(review)),
        "remarks": list(study_remarks(review)),
        **_on_the_way(review),
        "runs": [_run(run, review.metric_words) for run in review.runs],
    }
    return content


def _on_the_way(review: StudyReview) -> dict[str, Any]:
    descent = review.descent
    queries = {run.trial.number: run.query for run in review.runs}
    return {
        "descent": {
            "numbers": list(descent.numbers),
            "cost": _finite(descent.cost),
            "objective": _finite(descent.objective),
            "best": _finite(descent.best),
        },
        "mismatch": [
            {
                "run": number,
                "query": queries[number],
                "mismatch": mismatch,
                "lengthscale": source_lengthscale(mismatch),
                "query_cost": query_cost(mismatch),
            }
            for number, mismatch in review.mismatch
        ],
        "correction": [
            {"run": n, "query": queries[n], "twin": _number(twin), "corrected": _number(left)}
            for n, twin, left in review.correction
        ],
        "changes": [
            {"after": d.last_before, "found_at": d.found_at, "message": d.message}
            for d in review.drifts
        ],
        "twin_versions": [
            {
                "version": one.version,
                "reason": one.reason,
                "after": one.after,
                "learned": list(one.learned),
            }
            for one in review.twin_versions
        ],
    }


def study_json(content: dict[str, Any]) -> str:
    """Embed the content into the page.

    Parameters
    ----------
    content : dict
        Of `study_content`.
    """
    return embedded_json("study", json.dumps(content, separators=(",", ":"), allow_nan=False))


def _run(run: Run, words: MetricWords) -> dict[str, Any]:
    trial = run.trial
    known = trial.metrics.items()
    told = {
        "number": trial.number,
        "source": trial.source,
        "role": run.role,
        "query": run.query,
        "cost": run.cost,
        "gains": {name: _number(value) for name, value in trial.gains.items()},
        "objective": _number(trial.objective),
        "metrics": {name: _number(value) for name, value in known},
        "never": {n: words.text(n, value) for n, value in known if words.is_never(n, value)},
        "status": trial.status,
        "settled": has_settled(trial),
        "started": trial.started,
        "seconds": _number(trial.seconds),
        "parent": trial.parent,
    }
    if trial.sigma_c is not None:
        told["sigma_c"] = _number(trial.sigma_c)
    return told


def _place(review: StudyReview) -> int | None:
    if review.best is None:
        return None
    return review.descent.numbers.index(review.best.number) + 1


def _comparison(review: StudyReview) -> dict[str, dict[str, float | None]]:
    """First and best real run, and the relative improvement."""
    first, best = review.first, review.best
    if first is None or best is None:
        return {}
    rows = {"objective": (first.objective, best.objective)}
    rows |= {name: (first.metrics[name], best.metrics[name]) for name in review.metrics}
    return {
        name: {
            "first": _number(before),
            "best": _number(after),
            "change": _change(review.metric_words, name, before, after),
        }
        for name, (before, after) in rows.items()
    }


def _change(words: MetricWords, name: str, before: float, after: float) -> float | None:
    """Relative change of a metric; None where a share has no meaning."""
    # The cost may cross zero, and the horizon that stands for "never" is no measured time.
    if (
        name == "objective"
        or before <= 0.0
        or any(words.is_never(name, v) for v in (before, after))
    ):
        return None
    return _number((after - before) / before)


def _recommendation(review: StudyReview) -> dict[str, Any] | None:
    advised = review.recommendation
    if advised is None:
        return None
    return {
        "gains": {name: _number(value) for name, value in advised["gains"].items()},
        "mean": _number(advised["mean"]),
        "std": _number(advised["std"]),
    }


def _finite(values: Iterable[float]) -> list[float | None]:
    return [_number(value) for value in values]


def _number(value: float) -> float | None:
    plain = float(value)
    return plain if math.isfinite(plain) else None
