"""Which platforms are machines, and may be driven."""

from otolith.core.errors import InputError
from otolith.platforms.platform import Platform


def check_machine(platform: Platform, field: str) -> None:
    """Refuse the profile `thesis`, whose limits are beyond those of any machine.

    Raises
    ------
    InputError : it is this profile; `field` is what the platform was given as.
    """
    if platform.name == "thesis":
        raise InputError(field, "thesis", "a machine's: this profile has limits that no machine has")
