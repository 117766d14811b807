"""The command line: parse, call, write. One module per group of commands."""

from otolith.cli.app import main

__all__ = ["main"]
