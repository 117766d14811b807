"""The store of a study: Optuna's, in a journal file or a database, so that its own tools read it, too.

A trial is written whole when it is asked for, and the result of each of its jobs as soon as that is known,
with a checksum. So an interruption loses only jobs that were under way, and a store that was altered is
refused. Optuna's journal ignores a line that was cut while it was written, and then appends to it, which
makes the file unreadable for good (seen with Optuna 5.0); such a line is removed when a store is opened.
"""

import contextlib
import json
import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Final

from otolith.core.disk import NotWritten
from otolith.core.errors import CorruptFile, InputError, damage_reported
from otolith.studies.engine import optuna
from otolith.studies.jobs import JUDGING, TRAINING, Done, as_json
from otolith.studies.results import State, Trial

CONSTRAINT: Final = "constraints:"  # begins the names of attributes that Optuna reads as constraints
_DEFINITION: Final = "otolith"  # attribute of the study that holds how it was defined
_VERSION: Final = 1
_ALONE: Final = "one to which no other process writes"
STATES: Final = {  # as Optuna calls them
    State.DONE: optuna.trial.TrialState.COMPLETE,
    State.PRUNED: optuna.trial.TrialState.PRUNED,
    State.REJECTED: optuna.trial.TrialState.FAIL,
}
_OURS: Final = {there: here for here, there in STATES.items()}


class Store:
    """The trials of one study and how the study was defined.

    Examples
    --------
    >>> with Store.open("out/classical.journal") as store:
    ...     trials = store.trials()
    """

    def __init__(self, storage: Any, study_id: int, where: str, lock: Any = None) -> None:
        self._storage, self._id, self.where, self._lock = storage, study_id, where, lock

    @classmethod
    def create(cls, where: str, name: str, objectives: int, definition: Mapping[str, Any]) -> "Store":
        """Begin a store: a file that does not exist yet, or a database that holds no study of this name.

        Parameters
        ----------
        where : path of a journal file, or the URL of a database; empty: in memory.
        objectives : their number; all are made small.
        definition : plain values from which the study can be read again.

        Raises
        ------
        InputError : there is one already.
        """
        if where and not _is_url(where) and Path(where).exists():
            bound = "a new file; 'otolith study resume' goes on with a study"
            raise InputError("the store", f"{where}, which exists", bound)
        storage, lock = _storage(where, new=True)
        store = cls(storage, -1, where, lock)
        try:
            store._id = storage.create_new_study([optuna.study.StudyDirection.MINIMIZE] * objectives, name)
        except optuna.exceptions.DuplicatedStudyError:
            store.close()
            bound = "another; 'otolith study resume' goes on with a study"
            raise InputError(f"name of the study in {where}", repr(name), bound) from None
        store.note(_DEFINITION, {"version": _VERSION, **definition})
        return store

    @classmethod
    def open(cls, where: str, name: str | None = None, *, write: bool = False) -> "Store":
        """Open a store.

        Parameters
        ----------
        name : of the study; a file holds one only.
        write : whether trials will be added; then no other process may have it open for that.

        Raises
        ------
        InputError : there is no such store or study, or another process writes to it.
        CorruptFile : it is damaged, or was not made by `otolith study`.
        """
        if not _is_url(where) and not Path(where).is_file():
            raise InputError("the store", where, "a file of 'otolith study run', or the URL of a database")
        with _damage(where):
            storage, lock = _storage(where, write=write)
        store = cls(storage, -1, where, lock)
        try:
            store._choose(name)
        except BaseException:
            store.close()
            raise
        return store

    def _choose(self, name: str | None) -> None:
        """Find the study of this name, or the only one, and check all of it."""
        with _damage(self.where):
            known = {one.study_name: one._study_id for one in self._storage.get_all_studies()}
        if not known:
            raise CorruptFile(f"{self.where} is no sound study: it holds none")
        found = next(iter(known)) if name is None and len(known) == 1 else name
        if found is None or found not in known:
            raise InputError(f"name of the study in {self.where}", repr(name), f"one of {', '.join(known)}")
        self._id = known[found]
        with _damage(self.where):
            if self.definition["version"] != _VERSION:
                raise ValueError("it is of another version")
        self.trials()

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give it back, so that another process may write to it."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None
        if _is_url(self.where):
            self._storage.remove_session()
            self._storage.engine.dispose()

    @property
    def definition(self) -> dict[str, Any]:
        """Return the plain values that `create` was given."""
        return dict(self._storage.get_study_user_attrs(self._id)[_DEFINITION])

    def note(self, name: str, value: object) -> None:
        """Keep a plain value beside the trials."""
        self._storage.set_study_user_attr(self._id, name, value)

    def noted(self, name: str) -> Any:
        """Return a value that was noted; None if there is none."""
        return self._storage.get_study_user_attrs(self._id).get(name)

    def frozen(self) -> list[Any]:
        """Return the trials as Optuna has them, in order of their numbers."""
        trials: list[Any] = self._storage.get_all_trials(self._id, deepcopy=False)
        return sorted(trials, key=lambda one: one.number)

    def trials(self, numbers: range | None = None) -> list[Trial]:
        """Return the trials of these numbers, or all.

        Raises
        ------
        CorruptFile : a result does not belong to its trial.
        """
        with _damage(self.where):
            judged: dict[int, dict[str, Any]] = {}
            for name, value in self._storage.get_study_user_attrs(self._id).items():
                kind, _, rest = name.partition(" ")
                if kind == JUDGING:
                    number, _, item = rest.partition(" ")
                    judged.setdefault(int(number), {})[f"{JUDGING} {item}"] = value
            frozen = self.frozen()
            chosen = frozen if numbers is None else frozen[numbers.start : numbers.stop]
            return [_trial(one, {**one.user_attrs, **judged.get(one.number, {})}) for one in chosen]

    def add(
        self,
        number: int,
        params: Mapping[str, Any],
        distributions: Mapping[str, Any],
        system: Mapping[str, Any],
    ) -> None:
        """Write a trial that is to be done, as a whole.

        Raises
        ------
        InputError : its number is taken, since another process writes to the database.
        """
        if self._storage.get_n_trials(self._id) != number:
            raise self._shared()
        trial = optuna.trial.create_trial(
            state=optuna.trial.TrialState.RUNNING,
            params=dict(params),
            distributions=dict(distributions),
            system_attrs=dict(system),
        )
        self._storage.create_new_trial(self._id, template_trial=trial)

    def write(self, number: int, settings: Mapping[str, Any], kind: str, item: int, done: Done) -> None:
        """Write the result of a job of a trial; errors are those of `add`."""
        name = f"{kind} {item}"
        value = {**as_json(done), "check": _check(number, settings, name, as_json(done))}
        if kind == JUDGING:  # Optuna lets nobody add to a trial that is done
            self._storage.set_study_user_attr(self._id, f"{JUDGING} {number} {item}", value)
        else:
            with self._alone():
                self._storage.set_trial_user_attr(self._trial_id(number), name, value)

    def finish(
        self, number: int, state: State, values: Sequence[float], excesses: Mapping[str, float]
    ) -> None:
        """Write what became of a trial, whose training is done; errors are those of `add`."""
        where = self._trial_id(number)
        given = values if state is State.DONE else None
        with self._alone():
            for name, excess in excesses.items():
                self._storage.set_trial_system_attr(where, f"{CONSTRAINT}{name}", excess)
            self._storage.set_trial_state_values(where, STATES[state], given)

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        """Let a trial that another process has finished be one sentence; databases are not locked."""
        try:
            yield
        except optuna.exceptions.UpdateFinishedTrialError as error:
            raise self._shared() from error

    def _shared(self) -> InputError:
        return InputError("the store", f"{self.where}, to which another process writes", _ALONE)

    def _trial_id(self, number: int) -> int:
        found: int = self._storage.get_trial_id_from_study_id_trial_number(self._id, number)
        return found


def _trial(frozen: Any, attributes: Mapping[str, Any]) -> Trial:
    """Return a trial of Optuna as ours, with its results checked."""
    results: dict[str, dict[int, Done]] = {TRAINING: {}, JUDGING: {}}
    for name, value in attributes.items():
        kind, _, item = name.partition(" ")
        content = {key: one for key, one in value.items() if key != "check"}
        if value["check"] != _check(frozen.number, frozen.params, name, content):
            raise ValueError(f"{name} of trial {frozen.number} was altered")
        results[kind][int(item)] = Done(content.get("measures", {}), content.get("refused", ""))
    return Trial(
        number=frozen.number,
        settings=dict(frozen.params),
        training=results[TRAINING],
        judging=results[JUDGING],
        state=_OURS.get(frozen.state, State.OPEN),
    )


def _check(number: int, settings: Mapping[str, Any], name: str, content: Mapping[str, Any]) -> int:
    """Return a checksum of a result and of what it belongs to."""
    return zlib.crc32(json.dumps([number, dict(settings), name, content], sort_keys=True).encode())


def _is_url(where: str) -> bool:
    return "://" in where


def _storage(where: str, *, new: bool = False, write: bool = False) -> tuple[Any, Any]:
    """Return Optuna's storage, and the lock that keeps other writers away."""
    if not where:
        return optuna.storages.InMemoryStorage(), None
    if _is_url(where):
        return _database(where, new=new), None
    path = Path(where)
    path.parent.mkdir(parents=True, exist_ok=True)
    lock = _sole_writer(path) if new or write else None
    from optuna.storages import journal

    try:
        if path.exists():
            _check_lines(path, repair=write)
        held: Any = None if lock is None else _Held()
        backend = journal.JournalFileBackend(where, lock_obj=held)
        return optuna.storages.JournalStorage(backend), lock
    except BaseException:
        if lock is not None:
            lock.close()
        raise


def _database(url: str, *, new: bool) -> Any:
    """Return Optuna's storage in a database.

    Raises
    ------
    InputError : it cannot be opened, or is a file that does not exist, which opening it would make.
    """
    import sqlalchemy

    try:
        known = sqlalchemy.make_url(url)
        file = known.database if known.get_backend_name() == "sqlite" else None
        if not new and file and not Path(file).exists():
            raise InputError("the store", url, "a database that 'otolith study run' has made")
        return optuna.storages.RDBStorage(url)
    except (sqlalchemy.exc.SQLAlchemyError, ImportError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise InputError("the store", url, f"the URL of a database that can be opened ({reason})") from error


class _Held:
    """Optuna's lock of one write, which has nothing to do: `_sole_writer` holds the file all the time."""

    def acquire(self) -> bool:
        """Return that the lock is held."""
        return True

    def release(self) -> None:
        """Keep it."""


def _sole_writer(path: Path) -> IO[bytes] | None:
    """Lock a file for this process; the system unlocks it when the process ends, however it ends.

    Systems without such locks (Windows) leave it to the user that one process at a time writes.
    """
    if os.name != "posix":
        return None
    import fcntl

    try:
        file = path.open("ab")
    except OSError as error:
        raise NotWritten(path, error.strerror or str(error)) from error
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise InputError("the store", f"{path}, to which another process writes", _ALONE) from None
    return file


def _check_lines(path: Path, *, repair: bool) -> None:
    """Refuse a journal with a line that is none of Optuna's, which Optuna itself ignores if it is the last.

    Parameters
    ----------
    repair : whether a last line without an end, cut while it was written, is removed from the file; else it
        is left, since another process may be writing it.
    """
    whole = 0
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if not line.endswith(b"\n"):
                break
            whole += len(line)
            if "op_code" not in json.loads(line):
                raise ValueError(f"line {number} is no record")
    if repair and whole < path.stat().st_size:
        os.truncate(path, whole)


@contextlib.contextmanager
def _damage(where: str) -> Iterator[None]:
    """Turn what Optuna, SQLAlchemy or a parser raises on a damaged store into one sentence."""
    try:
        with damage_reported(f"{where} is no sound study"):
            yield
    except _not_optunas() as error:
        reason = str(error).splitlines()[0]
        raise CorruptFile(f"{where} is no sound study: {reason}") from error


def _not_optunas() -> tuple[type[Exception], ...]:
    """Return what is raised where a store is none of Optuna's."""
    import sqlalchemy.exc

    return optuna.exceptions.OptunaError, sqlalchemy.exc.SQLAlchemyError
