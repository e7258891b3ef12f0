"""The error budget: how large a residual may be without any physics missing.

`noise_levels.noise_levels` estimates noise and tolerance, `nuisances.nuisance_directions` what
every rig's clock, scales and zeros add, and `covariances.whiteners` the `whitening.Whitener` of
each of the windows from `windows.windows_of`. `signal_parts.describe_rig` describes the signals.
"""
