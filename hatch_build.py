"""Hooks of the build.

A wheel that holds machine code is one for this Python and system, and says so. The README that a package
carries has links that lead to the repository, since it is shown elsewhere.
"""

import json
import os
import sys
import sysconfig
import zipfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

ARCHIVE = "src/otolith/kernels.zip"  # made by tools/ship_kernels.py


class ReadmeHook(MetadataHookInterface):  # type: ignore[misc]
    """Makes the links of the README absolute where the repository's address is known to the build.

    OTOLITH_ADDRESS is that address, for instance that of the project on its host; a release sets it.
    """

    def update(self, metadata: dict[str, Any]) -> None:
        """Add the README, and the address itself."""
        sys.path.insert(0, str(Path(self.root) / "tools"))
        from readme_links import absolute

        address = os.environ.get("OTOLITH_ADDRESS", "").rstrip("/")
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        shown = absolute(text, address, metadata["version"])
        metadata["readme"] = {"content-type": "text/markdown", "text": shown}
        metadata["urls"] = {"Source": address} if address else {}


class MachineCodeHook(BuildHookInterface):  # type: ignore[misc]
    """Packs the archive of compiled kernels where there is one; without it the wheel fits everywhere."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Give the wheel the tag of its machine code.

        Raises
        ------
        RuntimeError : the archive was made by another Python than the one that builds, or of other source.
        """
        path = Path(self.root) / ARCHIVE
        if version != "standard" or not path.is_file():
            return
        sys.path.insert(0, str(Path(self.root) / "tools"))
        from source_digest import source_digest

        with zipfile.ZipFile(path) as archive:
            made_for = json.loads(archive.read("made-for.json"))
        here = {
            "extension suffix": str(sysconfig.get_config_var("EXT_SUFFIX")),
            "source": source_digest(path.parent),
        }
        for what, value in here.items():
            if made_for.get(what) != value:
                found = f"{what} {made_for.get(what)}, here is {value}"
                raise RuntimeError(f"{ARCHIVE} is for {found}: make it anew (make wheel), or remove it")
        build_data["pure_python"], build_data["infer_tag"] = False, True
