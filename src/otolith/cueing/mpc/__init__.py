"""Model predictive cueing: explicit, implicit, and the hybrids of both."""
