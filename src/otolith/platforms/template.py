"""A platform file to start from, with every field explained and the valid numbers of a small rig."""

from importlib.resources import files
from typing import Final, Literal

Kind = Literal["axes", "legs"]
_FOLDER: Final = files("otolith.platforms") / "templates"


def template(kind: Kind) -> str:
    """Return the text of a commented platform file.

    Parameters
    ----------
    kind : "axes" for a machine whose axes move one by one, such as a seat mover or a surge-pitch rig; "legs"
        for one on six actuators.
    """
    return (_FOLDER / f"{kind}.toml").read_text(encoding="utf-8")
