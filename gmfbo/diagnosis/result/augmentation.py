"""The augmented twin as values: enough to export it."""

from __future__ import annotations

import weakref
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.files.private_folder import PrivateFolder

if TYPE_CHECKING:
    from gmfbo.sources.export.export import AugmentedFmu, PhysicsParameter
    from gmfbo.sources.twin.twin import FmuTwin


@dataclass(frozen=True)
class Augmentation:
    """Values that turn the user's twin into the augmented one.

    Attributes
    ----------
    twin : FmuTwin, str or Path
        The user's twin, or its file.
    parameters : mapping of str to float
        [FMU's unit] Refitted parameters, by name; they become the defaults.
    physics : tuple of PhysicsParameter
        Parameters of the named effects, exposed as `physics.<effect>.<parameter>`.
    settings : mapping of str to float
        Settings of the physics FMU that are not for the user.
    substeps : int
        Steps of the physics in one communication step of the twin file.
    from_rest : bool
        Whether the recordings, and so the augmented twin, begin at rest under the named physics;
        [initial] of the user's twin then does not count.
    """

    twin: FmuTwin | str | Path
    parameters: Mapping[str, float]
    physics: tuple[PhysicsParameter, ...]
    settings: Mapping[str, float]
    substeps: int = 1
    from_rest: bool = False

    @property
    def twin_name(self) -> str:
        """Name of the user's twin, or of its file."""
        return Path(self.twin).name if isinstance(self.twin, (str, Path)) else self.twin.name

    @property
    def twin_file(self) -> Path:
        """The user's twin file."""
        return Path(self.twin) if isinstance(self.twin, (str, Path)) else self.twin.path

    def export(self, folder: Path) -> AugmentedFmu:
        """Write `augmented.fmu` and `augmented.toml` into an existing folder.

        Raises
        ------
        ExportError
            This twin cannot be exported.
        """
        from gmfbo.sources.export.export import export_augmented
        from gmfbo.sources.twin.twin import FmuTwin

        twin = FmuTwin(self.twin) if isinstance(self.twin, (str, Path)) else self.twin
        return export_augmented(
            twin,
            folder,
            parameters=self.parameters,
            physics=self.physics,
            settings=self.settings,
            substeps=self.substeps,
            from_rest=self.from_rest,
        )

    def opened(self, folder: Path | None = None) -> FmuTwin:
        """Export the augmented twin, and open it.

        Parameters
        ----------
        folder : Path, optional
            Existing folder for the files; without it they are gone once the twin is.

        Returns
        -------
        FmuTwin
            The augmented twin, which an FMU alone simulates.
        """
        from gmfbo.sources.twin.twin import FmuTwin

        if folder is not None:
            return FmuTwin(self.export(folder).twin_file)
        private = PrivateFolder()
        twin = FmuTwin(self.export(private.path).twin_file)
        # The finaliser holds the folder, so that it lives exactly as long as the twin.
        weakref.finalize(twin, private.remove)
        return twin
