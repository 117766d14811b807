"""A platform file to start from: every field explained, with numbers of a small rig that load as they are."""

from importlib.resources import files
from typing import Final, Literal

Kind = Literal["axes", "legs"]
_FOLDER: Final = files("otolith.platforms") / "templates"


def template(kind: Kind) -> str:
    """Text of a commented platform file.

    Parameters
    ----------
    kind : "axes" of a machine whose axes move one by one, such as a seat mover or a surge-pitch rig; "legs"
        of one that stands on six actuators.
    """
    return (_FOLDER / f"{kind}.toml").read_text(encoding="utf-8")
