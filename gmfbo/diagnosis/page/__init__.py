"""Write a diagnosis as a page and files: verdict, charts, effects and limits.

`saving.save` writes the folder; `charts.recordings_to_show` chooses which recordings are drawn.
"""
