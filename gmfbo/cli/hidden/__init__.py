"""What `gmfbo demo` hides in a plant, seals, records and, after the diagnosis, reveals.

The diagnosis gets the recordings and a twin; nothing of the draw is in their names or contents.
"""
