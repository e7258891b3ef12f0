"""Noise that the controller reads, in a twin whose FMU has no port that adds it to the reading.

What a push of the torque makes of position and command tells what the controller makes of its
reading. Noise of the reading then acts on the axis as the torque that the controller makes of it,
and the log has it in the reading and in the command besides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, toeplitz

from gmfbo.diagnosis.comparison.port_kernels import PortKernels, Pushed, through

Array = NDArray[np.float64]

_RIDGE = 1e-8  # of the position's answer: pushes are simulated to about 1e-11 of it
_REFINED = 2  # corrections for the ridge
_LONGEST = 1000  # rows: more take seconds, and a controller's answer to noise is shorter
_FIRST = 3  # rows of a derivative
_ALTERNATING = 0.5  # of an answer's energy: what changes so much from row to row is no controller
_AT_REST = 0.01  # of its largest: a position that has come back


@dataclass(frozen=True, eq=False)
class Controller:
    """What a controller makes of its reading, as impulse responses, shape (taps,).

    Attributes
    ----------
    logged : ndarray
        [SI unit of the command / FMU's unit of the position] In the log of the command.
    acting : ndarray
        [FMU's unit of the torque port / FMU's unit of the position] On the axis.
    """

    logged: Array
    acting: Array


def controllers_of(
    kernels: PortKernels, position: str, command: str, to_si: float
) -> Sequence[Controller] | None:
    """The controllers of all sets of gains; None where one cannot be told.

    Parameters
    ----------
    kernels : PortKernels
        Paths of the twin.
    position, command : str
        Outputs that are the reading and the controller's command.
    to_si : float
        [SI unit / FMU's unit] Of the position.
    """
    found: list[Controller] = []
    for own in _sets(kernels):
        controller = _controller(own, position, command, to_si)
        if controller is None:
            return None
        found.append(controller)
    return found


def with_reading(
    kernels: PortKernels,
    controllers: Sequence[Controller],
    position: str,
    command: str,
    to_si: float,
) -> PortKernels:
    """Paths with the answers to noise of the reading.

    Parameters
    ----------
    kernels : PortKernels
        Without, of the same recordings.
    controllers : sequence of Controller
        As `controllers_of` tells them.
    position, command, to_si
        As there.
    """

    def one(own: PortKernels, controller: Controller) -> PortKernels:
        pushed = own.simulated["torque"]
        simulated = {name: through(controller.acting, kernel) for name, kernel in pushed.items()}
        logged = dict(simulated)
        logged[position] = logged[position] + to_si * np.eye(1, controller.acting.size)[0]
        logged[command] = logged[command] + controller.logged
        return replace(
            own,
            kernels={**own.kernels, "sensor": logged},
            simulated={**own.simulated, "sensor": simulated},
            controller=controller.acting,
        )

    sets = _sets(kernels)
    found = dict(zip(sets, map(one, sets, controllers), strict=True))
    others = {k: found[own] for k, own in kernels.others.items()}
    return replace(found[kernels], others=others)


def _sets(kernels: PortKernels) -> list[PortKernels]:
    """Paths of each set of gains, once."""
    return list(dict.fromkeys([kernels, *kernels.others.values()]))


def _controller(own: PortKernels, position: str, command: str, to_si: float) -> Controller | None:
    pushed = own.pushed
    if pushed is None or not {position, command} <= own.simulated.get("torque", {}).keys():
        return None
    ratio = _torque_of_command(pushed)
    if ratio is None:
        return None
    read = pushed.position / to_si
    logged = controller_answer(read, own.simulated["torque"][command])
    acting = controller_answer(read, pushed.command)
    if logged is None or acting is None:
        return None
    return Controller(logged, ratio * acting)


def _torque_of_command(pushed: Pushed) -> float | None:
    """[FMU's unit of the torque port / SI unit of the command] In the long run.

    Commands take away what a push has given to an axis that comes back to where it was, through
    whatever gear and drive.
    """
    last = pushed.position[-max(pushed.position.size // 10, 1) :]
    taken = -float(np.sum(pushed.command))
    if taken == 0.0 or np.abs(last).max() > _AT_REST * np.abs(pushed.position).max():
        return None
    return 1.0 / taken


def controller_answer(position: Array, command: Array) -> Array | None:
    """Impulse response of a controller from its reading to its command, by least squares.

    None where there is none that a controller may have: one that reads more than rows of the
    position, as a velocity of its own, would answer these at half the sampling rate for long.

    Parameters
    ----------
    position, command : ndarray, shape (taps,)
        Answers to the same push.
    """
    first, made = position[:_LONGEST], command[:_LONGEST]
    if not (first.any() and made.any()):
        return None
    rows = toeplitz(first, np.zeros(first.size))
    square = rows.T @ rows
    square[np.diag_indices_from(square)] += _RIDGE**2 * np.trace(square) / first.size
    factor = cho_factor(square)
    found: Array = cho_solve(factor, rows.T @ made)
    for _ in range(_REFINED):
        found += cho_solve(factor, rows.T @ (made - rows @ found))
    answer = np.zeros(position.size)
    answer[: found.size] = found
    later = answer[int(np.argmax(np.abs(answer) > _AT_REST * np.abs(answer).max())) + _FIRST :]
    if np.sum(np.diff(later) ** 2) > _ALTERNATING * np.sum(answer**2):
        return None
    return answer
