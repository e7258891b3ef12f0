"""An effect of one's own: the page on FMUs shows how it is added; this adds it."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from fmu_build.build import SOURCES
from fmu_build.failure import BuildError
from fmu_build.own_effect import build_physics
from tests.fmu_build.fmu_instance import FmuInstance, unpacked_fmu


def documented() -> tuple[str, str, str, str]:
    """C function, its call, its parameter's name and description, from the page."""
    section = (SOURCES.parent / "notebooks" / "docs" / "own_effect.md").read_text(encoding="utf-8")
    function, call = (block.split("```")[0] for block in section.split("```c\n")[1:])
    (variable,) = tomllib.loads(section.split("```toml\n")[1].split("```")[0])["variable"]
    return function, call, variable["name"], variable["description"]


def test_the_effect_in_the_documentation_builds_and_acts(tmp_path: Path, zig_cache: Path) -> None:
    function, call, parameter, description = documented()
    name, _, last = parameter.partition(".")
    assert call.strip() == f"torque += {name}(v, s);", "what the builder puts in"
    path = build_physics(tmp_path / "mine" / "physics.fmu", name, function, {last: description})
    with unpacked_fmu(path) as unpacked:
        effects = FmuInstance(unpacked).start(cubic_spring__stiffness=2.0, state__position=3.0)
        effects.step(0.0, 1e-3)
        assert effects.get("torque") == pytest.approx(-54.0, rel=1e-15)
        effects.close()


def test_an_effect_at_the_sensor_acts_there_alone(tmp_path: Path, zig_cache: Path) -> None:
    law = """
    static inline double reading_error(const double *v, const Signals *s) {
        return v[V_reading_error_share] * s->position * s->position;
    }
    """
    path = build_physics(
        tmp_path / "physics.fmu",
        "reading_error",
        law,
        {"share": 'Of the square, "quoted"'},
        port="sensor",
    )
    with unpacked_fmu(path) as unpacked:
        effects = FmuInstance(unpacked).start(reading_error__share=0.5, state__position=2.0)
        effects.step(0.0, 1e-3)
        assert effects.get("sensor") == pytest.approx(2.0, rel=1e-15)
        assert effects.get("torque") == 0.0
        effects.close()


@pytest.mark.parametrize(
    ("name", "law", "message"),
    [
        ("Cubic Spring", "", "expected a name of small letters"),
        ("coulomb_friction", "", "has an effect 'coulomb_friction'; give yours another name"),
        ("cubic_spring", "static inline double cubic_spring(", "does not compile"),
    ],
)
def test_what_cannot_be_built_says_why(
    tmp_path: Path, zig_cache: Path, name: str, law: str, message: str
) -> None:
    with pytest.raises(BuildError, match=message):
        build_physics(tmp_path / "physics.fmu", name, law, {"stiffness": "Torque per angle cubed"})
    assert not (tmp_path / "physics.fmu").exists()
