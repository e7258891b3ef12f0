"""Draw what is missing: the curve of what is unknown, and that beside a named law."""
