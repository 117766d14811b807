"""Optuna, whose samplers and stores studies use; without it, one sentence says how it is installed.

Of the libraries that were weighed, pymoo has more algorithms of several objectives, but no store; Optuna has
NSGA-II and TPE with constraints, asks and tells, and keeps trials in a file or in any SQL database, which its
own dashboard reads.
"""

from otolith.core.errors import MissingExtra

try:
    import optuna as optuna
except ModuleNotFoundError as error:  # pragma: no cover (the tests have it)
    if error.name != "optuna":
        raise
    raise MissingExtra(
        "a study needs optuna, which is not installed: pip install 'otolith[study]'"
    ) from error

optuna.logging.set_verbosity(optuna.logging.WARNING)  # progress is told by the command
