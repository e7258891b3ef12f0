"""Show a comparison of tuning methods as one page that needs no network.

`page.comparison_page` writes it from a `curves.ComparisonReview`: a `curves.MethodSummary` for
each method, and the `curves.Landscape` of the true objective.
"""
