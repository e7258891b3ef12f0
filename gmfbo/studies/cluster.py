"""Open an executor of a cluster, by its name on the command line."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from gmfbo.errors import InputError, SimulationError

_CONNECT_S = 10.0


@contextmanager
def open_executor(name: str) -> Iterator[Executor]:
    """Connect to a cluster.

    Parameters
    ----------
    name : str
        `dask:ADDRESS` of a scheduler, such as `dask:tcp://10.0.0.5:8786`; or `mpi`, in a program
        that `mpiexec -n N python -m mpi4py.futures -m gmfbo ...` started.

    Raises
    ------
    InputError
        The name is neither, or its package is not installed.
    SimulationError
        Nobody answers at the address.
    """
    kind, _, address = name.partition(":")
    if kind == "dask" and address:
        with _dask(address) as executor:
            yield executor
    elif name == "mpi":
        with _mpi() as executor:
            yield executor
    else:
        raise InputError(
            f"executor: expected dask:ADDRESS, such as dask:tcp://127.0.0.1:8786, or mpi, got "
            f"'{name}'"
        )


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError:
        raise _not_installed("dask", "dask") from None
    try:
        client: Any = Client(  # type: ignore[no-untyped-call]
            address, timeout=_CONNECT_S, set_as_default=False
        )
    except (OSError, TimeoutError, ValueError) as error:
        raise SimulationError(
            f"no dask scheduler answers at {address} ({' '.join(str(error).split())}); start one "
            "with 'dask scheduler', and workers with 'dask worker ADDRESS --nthreads 1'"
        ) from None
    with client:
        # Runs differ by their labels, though dask may take two for the same call.
        yield client.get_executor(pure=False)


@contextmanager
def _mpi() -> Iterator[Executor]:
    try:
        from mpi4py.futures import MPIPoolExecutor
    except ImportError:
        raise _not_installed("mpi", "mpi4py and an MPI library") from None
    with MPIPoolExecutor() as executor:
        yield executor


def _not_installed(extra: str, what: str) -> InputError:
    return InputError(f"executor: needs {what}; install it with: pip install 'gmfbo[{extra}]'")
