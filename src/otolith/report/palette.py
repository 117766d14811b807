"""Colours that colour-blind readers, and readers of grey print, can distinguish.

Source: M. Okabe, K. Ito, Color Universal Design (2008).
"""

from typing import Final

BLUE: Final = "#0072B2"
VERMILION: Final = "#D55E00"
GREEN: Final = "#009E73"
PURPLE: Final = "#CC79A7"
ORANGE: Final = "#E69F00"
SKY: Final = "#56B4E9"
GREY: Final = "#8A8A8A"  # readable on white and on black

CYCLE: Final = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
DASHES: Final = ("solid", "dash", "dashdot", "dot")
