"""An FMU that starts a program, and one that opens a socket."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "13-refused-by-our-own-sandbox"
pytestmark = needs_case(CASE)


@pytest.mark.parametrize("name", ["spawn", "socket"])
def test_the_refusal_names_the_sandbox_and_its_switch(case: CaseFolder, name: str) -> None:
    answer = case.gmfbo(f"simulate {name}.toml --out s.csv")
    assert answer.code == 3
    assert "gmfbo shuts FMUs in" in answer.err
    for switch in ("GMFBO_SANDBOX=network", "GMFBO_SANDBOX=read=PATH", "GMFBO_SANDBOX=off"):
        assert switch in answer.err


def test_the_switch_that_is_named_helps(case: CaseFolder, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GMFBO_SANDBOX", "network")
    assert case.gmfbo("simulate socket.toml --out s.csv").code == 0
    refused = case.gmfbo("simulate spawn.toml --out s.csv")
    assert refused.code == 3
    assert "GMFBO_SANDBOX=network lets" not in refused.err
    monkeypatch.setenv("GMFBO_SANDBOX", "off")
    assert case.gmfbo("simulate spawn.toml --out s.csv").code == 0
