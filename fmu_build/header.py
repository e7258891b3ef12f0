"""The C side of a declaration: `variables.h` for the model, `variables.c` for the wrapper."""

from __future__ import annotations

import json
import math

from fmu_build.declaration import Declaration, Variable, c_name


def variables_header(declaration: Declaration) -> str:
    """Enumerators `V_<name>` (index into v[], of an array its first element), `N_VARIABLES`, and
    `INTERNAL_STEP` [s]."""
    lines = [
        "/* Generated from model.toml. */",
        "#ifndef GMFBO_VARIABLES_H",
        "#define GMFBO_VARIABLES_H",
        "",
        "enum {",
    ]
    lines += [f"    {c_name(name)} = {first}," for name, (first, _) in declaration.arrays.items()]
    lines += [f"    N_VARIABLES = {len(declaration.variables)}", "};", ""]
    lines += [f"#define INTERNAL_STEP {declaration.internal_step!r} /* [s] */", "", "#endif", ""]
    return "\n".join(lines)


def variables_table(declaration: Declaration, guid: str) -> str:
    """Definitions of the table that model.h declares."""
    lines = [
        "/* Generated from model.toml. */",
        "#include <math.h>",
        "",
        '#include "model.h"',
        "",
        f"const char model_name[] = {json.dumps(declaration.name)};",
        f"const char model_guid[] = {json.dumps(guid)};",
        "",
        "const Variable model_variables[N_VARIABLES] = {",
    ]
    lines += [f"    {_entry(variable)}," for variable in declaration.variables]
    lines += ["};", ""]
    return "\n".join(lines)


def _entry(variable: Variable) -> str:
    fields = (
        json.dumps(variable.name),
        json.dumps(variable.unit),
        _number(variable.start),
        _number(variable.low),
        _number(variable.high),
        f"CAUSALITY_{variable.causality.upper()}",
        f"TYPE_{variable.type.upper()}",
        str(int(variable.tunable)),
    )
    return "{" + ", ".join(fields) + "}"


def _number(value: float) -> str:
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value))
