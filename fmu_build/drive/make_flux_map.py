"""Writes the nominal flux map of the drive models to their resources.

The map is the gradient of a magnetic energy [J], with u = psi_d - psi_magnet and w = psi_q [Wb]:

    W(u, w) = u^2 / (2 L_d) + w^2 / (2 L_q) + s (u^2 + w^2)^2 / 4
    i_d = dW/du = u / L_d + s u (u^2 + w^2)
    i_q = dW/dw = w / L_q + s w (u^2 + w^2)

so that it gives back all energy it stores; the term with s [A/Wb^3] is saturation, with the
cross-coupling of the axes that belongs to it. A cubic polynomial is a cubic spline, so the
spline's coefficients follow in closed form and reproduce the formula exactly up to one cell from
the edge of the table, where it begins to go over into its linear continuation: on knots h apart,
the coefficients of 1, x, x^2 and x^3 at the node x are 1, x, x^2 - h^2/3 and x^3 - h^2 x.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

NODES = 5
HALF_WIDTH = 15e-3  # [Wb]
INDUCTANCE_D, INDUCTANCE_Q = 3.0e-4, 3.6e-4  # [H]
SATURATION = 4.5e6  # [A/Wb^3]

HEADER = """\
# Nominal inverse flux-linkage map of the drive, made by fmu_build/drive/make_flux_map.py.
# Nodes a side; half width of the table [pWb], flux along d counted from that of the magnets;
# coefficients of the cubic B-spline for i_d, then for i_q [nA], a row for each node along psi_d.
"""


def coefficients() -> NDArray[np.float64]:
    """Spline coefficients [A], shape (2, NODES, NODES): i_d and i_q, rows along psi_d."""
    x = np.linspace(-HALF_WIDTH, HALF_WIDTH, NODES)
    h = x[1] - x[0]
    square, cube, one = x**2 - h**2 / 3.0, x**3 - h**2 * x, np.ones(NODES)
    i_d = np.outer(x / INDUCTANCE_D + SATURATION * cube, one) + SATURATION * np.outer(x, square)
    i_q = np.outer(one, x / INDUCTANCE_Q + SATURATION * cube) + SATURATION * np.outer(square, x)
    return np.stack([i_d, i_q])


def main() -> None:
    """Write the same table for every model that contains the motor."""
    lines = [f"{NODES}", f"{round(HALF_WIDTH * 1e12)}"]
    for table in coefficients():
        lines += [" ".join(str(round(value * 1e9)) for value in row) for row in table]
    text = HEADER + "\n".join(lines) + "\n"
    for model in ("drive_twin", "drive_plant"):
        folder = Path(__file__).resolve().parents[1] / model / "resources"
        folder.mkdir(exist_ok=True)
        (folder / "flux_map.txt").write_text(text, encoding="ascii", newline="\n")


if __name__ == "__main__":
    main()
