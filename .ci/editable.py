"""Build hook of hatchling: an editable install finds the package by links, and stops here where they are absent."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Editable(BuildHookInterface):  # type: ignore[type-arg]
    """Looks for the link to each folder of the package."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002 - as hatchling calls it
        """Stop an editable build without links, naming the first that is absent."""
        (folder,) = self.build_config.dev_mode_dirs
        for package in self.build_config.target_config["sources"].values():
            link = Path(folder, package)
            if version == "editable" and not Path(self.root, link).is_dir():
                self.app.abort(
                    f"{link} is no link to a folder: an editable install needs the links of a checkout, which a zip, or a "
                    "clone on Windows, has not. There: git config core.symlinks true, and git checkout -- "
                    f"{folder} (Windows: in developer mode). Or install without -e, which needs no links."
                )
