"""Sets of motions that an axis need never leave, found and proved by its vertices."""
