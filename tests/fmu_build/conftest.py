"""FMUs as they are committed, unpacked once a session, and instances of them."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from gmfbo.sources.fmu_file.models import models_folder

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:  # last, so that an installed gmfbo is the one that is tested
    sys.path.append(str(ROOT))

from tests.fmu_build.fmu_instance import FmuInstance, unpacked_fmu  # noqa: E402

NewInstance = Callable[..., FmuInstance]


@pytest.fixture(scope="session", autouse=True)
def zig_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """One copy of zig's system libraries for all tests; the models are compiled anew each time."""
    with pytest.MonkeyPatch.context() as patch:
        if "ZIG_GLOBAL_CACHE_DIR" not in os.environ:
            own = tmp_path_factory.getbasetemp()
            # Each test process has a folder of its own in one of the run; zig locks its cache.
            run = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
            patch.setenv("ZIG_GLOBAL_CACHE_DIR", str(run / "zig"))
        yield Path(os.environ["ZIG_GLOBAL_CACHE_DIR"])


@pytest.fixture(scope="session")
def unpacked() -> Iterator[Callable[[str], Path]]:
    """Folder of an unpacked FMU, by its name in models/ or tests/fmus/."""
    folders: dict[str, Path] = {}
    with ExitStack() as stack:

        def unpack(name: str) -> Path:
            if name not in folders:
                shipped = models_folder() / f"{name}.fmu"
                path = shipped if shipped.is_file() else ROOT / "tests" / "fmus" / f"{name}.fmu"
                folders[name] = stack.enter_context(unpacked_fmu(path))
            return folders[name]

        yield unpack


@pytest.fixture
def new_instance(unpacked: Callable[[str], Path]) -> Iterator[NewInstance]:
    """Instances by FMU name, freed at the end of the test."""
    instances: list[FmuInstance] = []

    def instantiate(name: str, guid: str | None = None) -> FmuInstance:
        instances.append(FmuInstance(unpacked(name), guid))
        return instances[-1]

    yield instantiate
    for instance in instances:
        instance.close()
