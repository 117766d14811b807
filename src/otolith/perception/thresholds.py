"""Tilt rates that are not perceived as rotation (thesis, Table B.5), in the units of the table."""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class TiltThreshold:
    """The threshold of tilt rate in one source; None where the source gives none."""

    source: str
    pitch_degps: float | None
    roll_degps: float | None


TILT_THRESHOLDS: Final = (
    TiltThreshold("Gutridge (2004), Virginia Tech", 3.0, 3.0),
    TiltThreshold("Reid & Nahon (1985), UTIAS 296", 3.0, 2.3),
    TiltThreshold("Khusro et al. (2020), doi 10.3390/vehicles2040036", 3.6, 3.0),
    TiltThreshold("Lamprecht et al. (2021), doi 10.1109/tits.2021.3114003", 3.0, 4.0),
    TiltThreshold("Telban & Cardullo (2005), NASA CR-2005-213747", 2.0, 2.0),
    TiltThreshold("Koyuncu et al. (2020), doi 10.1109/IV47402.2020.9304825", 2.04, 2.04),
    TiltThreshold("Munir et al. (2017), doi 10.1016/j.ifacol.2017.08.2256", 6.0, None),
    TiltThreshold("Soyer et al. (2021), doi 10.1016/j.ifacol.2021.08.567", 6.0, None),
    TiltThreshold(
        "Nesti et al. (2012), Roll rate thresholds and perceived realism in driving simulation", None, 6.3
    ),
)
