"""Pages and figures of what gmfbo found."""
