"""The part of a structured engine that is written, not generated.

Each module here is ordinary code against the names of `given`; `generate` puts the text below its
marker line, together with the emitted recursions, into the module of one structure, where those
names are constants and functions of that structure.
"""
