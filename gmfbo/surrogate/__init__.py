import gmfbo.correction.torch_setup  # noqa: F401 - torch is set up before any module here uses it
