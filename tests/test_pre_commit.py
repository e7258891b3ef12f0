"""The hooks before a commit are the static checks of `.ci/run`."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HOOKS = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")


def test_hooks_run_the_static_checks_of_ci() -> None:
    script = (ROOT / ".ci/run").read_text()
    checks = re.findall(r"^ +(\S.*) \|\| failed=1$", script, re.MULTILINE)
    assert len(checks) == 4
    assert re.findall(r"^ +entry: (.+)$", HOOKS, re.MULTILINE) == checks


def test_hooks_come_from_the_checkout_and_see_the_whole_package() -> None:
    assert re.findall(r"repo: (.+)", HOOKS) == ["local"]
    hooks = re.findall(r"- id: ", HOOKS)
    assert HOOKS.count("language: system") == len(hooks)
    assert HOOKS.count("pass_filenames: false") == len(hooks)
