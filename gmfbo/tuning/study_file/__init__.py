"""The study file: what is tuned, on which sources, by which method, for how long.

`study_file.read_study_file` gives a validated `study_sections.StudyFile`, and
`gain_choice.GainChoice` which gains are moved and which are held.
"""
