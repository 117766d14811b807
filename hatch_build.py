"""Hook of the build: a wheel that holds machine code is one for this Python and system, and says so."""

import json
import sys
import sysconfig
import zipfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ARCHIVE = "src/otolith/kernels.zip"  # made by tools/ship_kernels.py


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
