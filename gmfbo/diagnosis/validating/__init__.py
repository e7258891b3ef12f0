"""Test the augmented twin on held-out recordings, and its residuals.

`validation.validate` compares its errors with those of the twin before, on recordings that no
fit used; `reference_tests.residual_tests` tests whether a residual still follows the reference.
"""
