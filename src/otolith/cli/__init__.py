"""The command line: parse, call, write. One module per group of commands."""

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> None:
    """Run the program; see `otolith.cli.app.run_program`.

    Signals are handled before anything else is imported, so that Ctrl-C works at any moment.
    """
    from otolith.cli.stop import signals_stop

    with signals_stop():
        from otolith.cli.app import run_program

        run_program(arguments)
