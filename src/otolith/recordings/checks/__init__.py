"""What physics says of a recorded drive: which way is left, what contradicts what, and what would mend it."""
