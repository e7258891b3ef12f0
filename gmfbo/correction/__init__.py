"""Correct simulated trajectories by real ones with Gaussian processes: source IS3.

`trajectory_gp.TrajectoryCorrection` learns from each `trajectory_gp.Pair` of a real and a
simulated run; `local_samples.draw_local_samples` runs the corrected twin near real gains;
`residual_process.ResidualProcess` models the residual over whole trajectories;
`torch_setup.exact_algebra` keeps torch's linear algebra exact.
"""

import gmfbo.correction.torch_setup  # noqa: F401 - torch is set up before any module here uses it
