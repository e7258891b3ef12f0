"""Sources of the project's own FMUs and how they are built: `gmfbo build`."""
