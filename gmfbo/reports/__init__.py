"""Pages and figures of studies and comparisons.

`study.page` and `comparison.page` write pages that need no network; `figures.study_figures` and
`figures.comparison_figures` draw the same for a notebook or a paper.
"""
