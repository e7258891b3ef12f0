"""What the plants are: simulators apart from gmfbo's FMUs, but for the two drives."""
