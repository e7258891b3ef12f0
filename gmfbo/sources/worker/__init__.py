"""Run a twin's FMUs in a process of its own, which may crash, exit or hang.

`runner.Runner` is what runs an `runner.Order` and gives a `runner.Result`: `isolation.Isolated`
in a worker process, `runner.InProcess` in this one.
"""
