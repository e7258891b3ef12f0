"""Levels of noise about a fit: of three places at high frequencies, and over the whole band."""
