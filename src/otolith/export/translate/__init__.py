"""Kernels as C99: a back end beside numba's for the same source text.

`unit.Unit` translates a kernel and all that it calls, for one set of data: what a kernel reads of a named
tuple is known when it is translated, so sizes are literals, branches that the data rule out are left out, and
methods that are called by address (`otolith.core.methods`) become calls of functions. Arrays that nothing
writes become constants, all others members of one struct.

`values` says what an expression can be, `expressions` and `builtins` translate expressions, `body` the
statements of one function, `render` writes the text.
"""
