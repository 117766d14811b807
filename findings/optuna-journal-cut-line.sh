#!/bin/sh
# optuna 5.0.0: after a process was killed while it wrote, a study in a journal file is lost to the next one.
#
# JournalFileBackend appends one line of JSON per operation. A line that a kill (or a full disk) has cut short is ignored
# by those who read. But whoever opens the study next appends its own line to the rest of it, and from then on the
# file cannot be read: every start ends with a JSONDecodeError, though all trials before the cut are still there. A guess
# from the name was that a journal recovers by itself. Who keeps a study in a journal file has to cut the
# file at its last whole line before optuna opens it.
#
# Run by hand. Exits 0 while this holds, 1 once it does not.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet "optuna==5.0.0"
cd "$folder"
cat > search.py <<'PYTHON'
import json
import sys
from pathlib import Path

import optuna
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend

optuna.logging.set_verbosity(optuna.logging.ERROR)
JOURNAL = Path("journal.log")


def search(trials):
    """Go on with the study as a new process does; return how many trials it has, or what went wrong."""
    try:
        study = optuna.create_study(
            storage=JournalStorage(JournalFileBackend(str(JOURNAL))),
            study_name="one",
            load_if_exists=True,
            sampler=optuna.samplers.RandomSampler(seed=1),
        )
        study.optimize(lambda trial: trial.suggest_float("x", 0.0, 1.0) ** 2, n_trials=trials)
    except json.JSONDecodeError as error:
        return f"JSONDecodeError: {error}"
    return len(study.trials)


print("optuna", optuna.__version__)
print("three trials:", search(3))
lines = JOURNAL.read_bytes().splitlines(keepends=True)
whole, cut = b"".join(lines[:-1]), lines[-1][: len(lines[-1]) // 2]
JOURNAL.write_bytes(whole + cut)
first, second = search(2), search(1)
print("the last line cut short, two more:", first)
print("once more:", second)
JOURNAL.write_bytes(whole)
mended = search(1)
print("cut at its last whole line instead, one more:", mended)
lost = isinstance(first, str) and isinstance(second, str)
sys.exit(0 if lost and mended == 4 else 1)
PYTHON
"$folder/venv/bin/python" search.py
