"""Pages and figures of studies, comparisons and simulations.

`study.page`, `comparison.page` and `simulation.page` write pages that need no network;
`figures.study_figures` and `figures.comparison_figures` draw the same for a notebook or a paper.
"""
