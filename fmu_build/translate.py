"""Modelica to C, by the package `modelica`; the result is committed, so a plain build needs none.

The C file carries the hash of its Modelica source. Building checks it, so that a changed model
cannot be built from an old translation.
"""

from __future__ import annotations

import hashlib
import importlib.util
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from fmu_build.failure import BuildError

if TYPE_CHECKING:
    from modelica.sim.emit import Code

# The translator leaves what is declared `input` without a value in its C code; as parameters the
# same names arrive in p[], which the C side may change at any time.
_INPUT = re.compile(r"\binput (Real \w+(?:\([^)]*\))?)")
_EXPECTED_WARNINGS = ("-Wunused-parameter", "-Wunused-variable", "-Wunused-but-set-variable")


def translate_model(folder: Path, report: Callable[[str], None]) -> None:
    """Translate every `.mo` file of a model's folder to a `.c` and a `.h` of the same name.

    Raises
    ------
    BuildError
        Before Python 3.12, or without the package `modelica`.
    """
    for source in sorted(folder.glob("*.mo")):
        _require_translator(source)
        code, header = _translate(source)
        source.with_suffix(".c").write_text(code, encoding="utf-8")
        source.with_suffix(".h").write_text(header, encoding="utf-8")
        report(f"{source.name}: translated")


def check_translation(folder: Path) -> None:
    """Refuse a Modelica source that is newer than its C code.

    Raises
    ------
    BuildError
        With the file and the command that brings it up to date.
    """
    for source in sorted(folder.glob("*.mo")):
        code = source.with_suffix(".c")
        if not code.is_file() or _origin(source) not in code.read_text(encoding="utf-8"):
            raise BuildError(
                f"{source.name} differs from the model that {code.name} was translated from: "
                "build with --translate on Python 3.12 or later"
            )


def _require_translator(source: Path) -> None:
    if sys.version_info < (3, 12):
        raise BuildError(
            f"{source.name}: translating Modelica needs Python 3.12 or later, this is "
            f"{sys.version_info[0]}.{sys.version_info[1]}; build without --translate to use "
            "the committed C"
        )
    if importlib.util.find_spec("modelica") is None:
        raise BuildError('the package modelica is missing: pip install "gmfbo[translate]"')


def _origin(source: Path) -> str:
    text = source.read_bytes().replace(b"\r\n", b"\n")
    return f"SHA-256 {hashlib.sha256(text).hexdigest()}"


def _translate(source: Path) -> tuple[str, str]:
    from modelica.lang import parse
    from modelica.sim import causalize, flatten
    from modelica.sim.cgen import unit
    from modelica.sim.emit import emit

    text = _INPUT.sub(r"parameter \1 = 0", source.read_text(encoding="utf-8"))
    system = causalize(flatten([parse(text)], source.stem))
    code = emit(system)
    if code.events or code.switching is not None:
        raise BuildError(f"{source.name}: events are not supported; write them in the model's C")
    comment = f"/* {source.name}, {_origin(source)}: translated by the package modelica. */\n"
    pragmas = "".join(
        f'#pragma GCC diagnostic ignored "{warning}"\n' for warning in _EXPECTED_WARNINGS
    )
    header = _header(source.stem, code)
    return comment + f'#include "{source.stem}.h"\n\n' + pragmas + unit(system), comment + header


def _header(model: str, code: Code) -> str:
    guard = f"GMFBO_{model.upper()}_H"
    groups = {"STATE": code.states, "PARAMETER": code.parameters, "OBSERVED": code.observed}
    lines = [f"#ifndef {guard}", f"#define {guard}", ""]
    for group, names in groups.items():
        entries = [f"{group}_{re.sub('[^A-Za-z0-9]', '_', name)}" for name in names]
        lines += ["enum {", *(f"    {entry}," for entry in entries), f"    N_{group}", "};", ""]
    lines += [
        f"enum {{ N_WORKSPACE = {code.workspace} }};",
        "",
        "/* t: time, y: states, p: parameters and inputs, w: workspace, dy: derivatives of y. */",
        "void rhs(double t, const double *y, const double *p, double *w, double *dy);",
        "void observe(double t, const double *y, const double *p, double *w, double *out);",
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)
