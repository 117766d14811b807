"""Hook of the build: this distribution uses the insides of Otolith, so it needs the very same version."""

from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface


class SameVersionHook(MetadataHookInterface):  # type: ignore[misc]
    """States the dependencies, of which one has the version of this distribution."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add the dependencies."""
        metadata["dependencies"] = [
            f"otolith=={metadata['version']}",
            "numpy>=2.0",
            "scipy>=1.13",
            "pydantic>=2.8",
            "typer>=0.15",
            "rich>=13.7",
            "matplotlib>=3.9",
        ]
