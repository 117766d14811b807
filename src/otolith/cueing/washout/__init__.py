"""Conventional motion cueing: classical, optimal and adaptive washout (thesis, section 2.2)."""
