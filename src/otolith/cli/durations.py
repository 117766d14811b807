"""Times that options are given: how long a session, a recording or a measurement lasts."""

import typer

from otolith.core.errors import InputError

LONGEST = 100.0 * 3600.0  # [s]


def check_duration(name: str, seconds: float, *, least: float, most: float) -> float:
    """Return a time [s] that is within bounds.

    Raises
    ------
    InputError : it is not; neither is what is no number.
    """
    if not least <= seconds <= most:
        raise InputError(name, f"{seconds:g} s", f"from {least:g} to {most:g} s")
    return seconds


def lasting(words: str, *, least: float, most: float = LONGEST) -> typer.models.OptionInfo:
    """Return an option that takes a time [s] between two bounds.

    Parameters
    ----------
    words : for its help, without a full stop.
    """

    def checked(parameter: typer.CallbackParam, seconds: float | None) -> float | None:
        name = parameter.opts[0]
        return None if seconds is None else check_duration(name, seconds, least=least, most=most)

    help_ = f"{words}, from {least:g} to {most:g} s."
    option: typer.models.OptionInfo = typer.Option(metavar="SECONDS", help=help_, callback=checked)
    return option
