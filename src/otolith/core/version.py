"""The version of the installed distribution, which the build takes from the tag of its commit."""

from importlib.metadata import PackageNotFoundError, version
from typing import Final

NOT_INSTALLED: Final = "0+not.installed"


def installed(name: str = "otolith") -> str:
    """Return the version of a distribution, or NOT_INSTALLED for a folder that is only on the path."""
    try:
        return version(name)
    except PackageNotFoundError:
        return NOT_INSTALLED


VERSION: Final = installed()
