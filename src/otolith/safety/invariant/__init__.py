"""Sets of motions in which an axis can always stay, found and proved by their vertices."""
