"""Surrogates: Gaussian processes of the objective g over gains and source.

`observations.Observations` is their data. `model.SourceModel` correlates the sources by a
lengthscale over the source, `truncated.TruncatedModel` is BoTorch's, and
`corrected_twin.CorrectedTwinModel` has the corrected twin's objective as its prior mean.
"""

import gmfbo.correction.torch_setup  # noqa: F401 - torch is set up before any module here uses it
