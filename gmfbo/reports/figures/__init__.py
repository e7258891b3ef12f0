"""Draw figures for notebooks and papers; they need matplotlib.

`study_figures.draw_study` and `comparison_figures.draw_comparison` write the figures of a study
and of a comparison; `notebook_figure.NotebookFigure` is a figure that a notebook shows.
"""
