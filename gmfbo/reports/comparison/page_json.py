"""Numbers of a comparison's page, as the JSON embedded in it."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from gmfbo.pages.html_page import embedded_json
from gmfbo.reports.comparison.curves import ComparisonReview


def comparison_content(review: ComparisonReview) -> dict[str, Any]:
    """Content of a comparison in numbers and names.

    Parameters
    ----------
    review : ComparisonReview
        Read from a comparison's folder.

    Returns
    -------
    dict
        JSON values.
    """
    return {
        "schema": 1,
        "name": review.name,
        "methods": [asdict(one) for one in review.methods],
        "runs": [
            {**asdict(run), "best": run.best.tolist(), "regret": run.regret.tolist()}
            for run in review.runs
        ],
        "curves": [
            {
                "method": curve.method,
                "name": curve.name,
                "seeds": curve.seeds,
                **{key: getattr(curve, key).tolist() for key in ("x", "mean", "low", "high")},
            }
            for curve in review.curves
        ],
    }


def comparison_json(content: dict[str, Any]) -> str:
    """Embed the content into the page.

    Parameters
    ----------
    content : dict
        Of `comparison_content`.
    """
    told = json.dumps(content, separators=(",", ":"), allow_nan=False)
    return embedded_json("comparison", told)
