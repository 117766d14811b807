"""What every layer stands on: errors, arrays, frames, compiled kernels. Knows no algorithm."""
