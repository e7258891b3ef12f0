"""A study opened: its file, its sources, and each query played.

`study.Study` holds the file and the runs so far, `study_sources.StudySources` the sources, and
`playing.play` plays a query; `study_terms.own_metrics` and `study_terms.known_safe` read what
the file says of metrics and safety.
"""
