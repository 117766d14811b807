"""The foundation of every other layer: errors, arrays, frames, compiled kernels. It knows no algorithm."""
