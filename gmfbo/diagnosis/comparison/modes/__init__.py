"""The most likely values of one hypothesis, searched through the FMU."""
