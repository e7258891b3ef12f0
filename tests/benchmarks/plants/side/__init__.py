"""Methods of the side table: rivals that others made, and variants of ours."""
