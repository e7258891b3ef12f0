"""What the plants are: simulators written apart from gmfbo's FMUs, except those of the two drives."""
