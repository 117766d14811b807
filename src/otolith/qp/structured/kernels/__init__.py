"""The handwritten part of a structured engine, in contrast to the generated one.

Each module here is ordinary code that uses the names of `kernel_symbols`. `generate` copies the text below
the marker line, together with the emitted recursions, into the module of one structure. There these names are
constants and functions of that structure.
"""
