"""Physics of a recorded drive: the direction of its axes, its contradictions, and their remedies."""
