"""Surrogates: Gaussian processes of the objective g over gains and source.

`observations.Observations` is their data. `model.SourceModel` fixes the correlation between the
sources, `coregionalised.CoregionalisedModel` learns it, `truncated.TruncatedModel` is BoTorch's,
and `corrected_twin.CorrectedTwinModel` has the corrected twin's objective as its prior mean.
"""

import gmfbo.correction.torch_setup  # noqa: F401 - torch is set up before any module here uses it
