"""Choose the next query by expected improvement or knowledge gradient per cost.

`maximise.maximise` finds the gains with the largest value among the criteria
`improvement.CostAwareExpectedImprovement` and `knowledge_gradient.KnowledgeGradient`, weighted
by `feasibility.FeasibilityWeight`; `maximise.recommend` gives the gains to end with.
"""

import gmfbo.correction.torch_setup  # noqa: F401 - torch is set up before any module here uses it
