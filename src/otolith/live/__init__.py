"""Live operation: telemetry in, set-points for a motion platform out, and an answer to every fault."""
