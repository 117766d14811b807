"""A study is the same however it is done, and an interrupted one goes on as if it had not been."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith.core.errors import CorruptFile, InputError
from otolith.studies.results import State, values
from otolith.studies.store import Store
from tests.studies.synthetic import Interrupted, Stopping, created, search, study

PRUNED: dict[str, Any] = {"prune_percentile": 50.0, "prune_after": 1}


@pytest.mark.parametrize("pruned", [{}, PRUNED], ids=["whole", "pruned"])
@pytest.mark.parametrize("sampler", ["nsga2", "tpe", "random"])
def test_the_same_study_gives_the_same_trials_in_whatever_order_its_jobs_are_done(
    sampler: str, pruned: dict[str, Any]
) -> None:
    of = study(sampler=sampler, **pruned)
    first = search(of, created("", of))
    assert [trial.number for trial in first] == list(range(14))
    assert State.OPEN not in {trial.state for trial in first}
    assert (State.PRUNED in {trial.state for trial in first}) == bool(pruned)
    assert search(of, created("", of), Stopping(backwards=True)) == first
    other = study(sampler=sampler, seed=2, **pruned)
    assert search(other, created("", other)) != first


@pytest.mark.parametrize(("sampler", "pruned"), [("nsga2", {}), ("tpe", {}), ("nsga2", PRUNED)])
@pytest.mark.parametrize("jobs", [0, 3, 8, 13, 20])
def test_an_interrupted_study_loses_nothing_and_does_nothing_twice(
    sampler: str, pruned: dict[str, Any], jobs: int, tmp_path: Path
) -> None:
    of = study(sampler=sampler, **pruned)
    whole = Stopping()
    expected = search(of, created("", of), whole)
    path, before, after = tmp_path / "a.journal", Stopping(jobs), Stopping()
    with created(path, of) as store, pytest.raises(Interrupted):
        search(of, store, before)
    with Store.open(str(path), write=True) as store:
        assert search(of, store, after) == expected
    assert before.done + after.done == whole.done
    again = Stopping(0)
    with Store.open(str(path), write=True) as store:
        assert search(of, store, again) == expected


def test_settings_that_are_refused_reject_their_trial_alone() -> None:
    of = study(trials=40, batch=10)
    trials = search(of, created("", of))
    rejected = [trial for trial in trials if trial.state is State.REJECTED]
    assert rejected
    for trial in trials:
        refused = trial.settings["horizon"] == 50 and float(trial.settings["weight.velocity"]) > 0.5
        assert refused == (trial in rejected)


def test_a_trial_ends_early_where_it_is_in_the_worse_half_of_earlier_batches_by_every_objective() -> None:
    of = study(trials=60, batch=10, sampler="random", **PRUNED)
    trials = search(of, created("", of))
    expected = set()
    for trial in trials:
        finished = [t for t in trials[: trial.number // 10 * 10] if t.state is State.DONE]
        if finished and trial.state is not State.REJECTED:
            medians = np.median([values(of, {0: t.training[0]}) for t in finished], axis=0)
            if (np.array(values(of, {0: trial.training[0]})) > medians).all():
                expected.add(trial.number)
    assert expected == {trial.number for trial in trials if trial.state is State.PRUNED}
    assert 5 < len(expected) < 30
    assert {len(trials[number].training) for number in expected} == {1}
    of = study(trials=60, batch=10, sampler="random", prune_percentile=50.0)  # after three references
    assert State.PRUNED not in {trial.state for trial in search(of, created("", of))}


def test_the_start_is_tried_first_and_a_search_is_better_than_it() -> None:
    of = study(trials=60, batch=10)
    trials = search(of, created("", of))
    assert dict(trials[0].settings) == dict(of.start[0])
    assert min(t.training[0].measures["travel"] for t in trials if t.state is State.DONE) < 0.25


def test_a_database_holds_what_a_file_does(tmp_path: Path) -> None:
    of = study(trials=5)
    url = f"sqlite:///{tmp_path}/studies.db"
    with created(url, of) as database, created(tmp_path / "a.journal", of) as file:
        assert search(of, database) == search(of, file)
    with Store.open(url, "formula") as database:
        assert len(database.trials()) == 5
    with pytest.raises(InputError, match="name of the study in sqlite"):
        created(url, of)


def test_of_two_processes_on_one_database_one_goes_on_and_the_other_says_why(tmp_path: Path) -> None:
    of, url = study(trials=3, batch=2), f"sqlite:///{tmp_path}/studies.db"
    with created(url, of) as store, pytest.raises(Interrupted):
        search(of, store, Stopping(1))

    class Overtaken(Stopping):
        """Does its jobs after another process has done the whole study."""

        def as_done(self, work: Any, items: Any) -> Any:
            with Store.open(url, write=True) as other:
                search(of, other)
            return super().as_done(work, items)

    refused = "to which another process writes, must be one to which no other process writes"
    with Store.open(url, write=True) as store, pytest.raises(InputError, match=refused):
        search(of, store, Overtaken())
    expected = search(of, created("", of))
    with Store.open(url, write=True) as store:
        assert store.trials() == expected
        with pytest.raises(InputError, match=refused):
            store.add(2, {}, {}, {})


def test_a_database_that_cannot_be_opened_is_one_sentence_and_reading_makes_none(tmp_path: Path) -> None:
    for url in (f"sqlite:///{tmp_path}/none/a.db", "nonsense://a"):
        with pytest.raises(InputError, match="must be the URL of a database that can be opened"):
            created(url, study())
    with pytest.raises(InputError, match="must be a database that 'otolith study run' has made"):
        Store.open(f"sqlite:///{tmp_path}/a.db")
    assert not list(tmp_path.iterdir())


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    of = study(trials=4)
    path = tmp_path / "a.journal"
    with created(path, of) as store:
        search(of, store)
    return path


def edited(text: bytes, how: str) -> bytes:
    if how == "cut":
        return text[:-20] + b"\n"
    if how == "number":
        place = text.index(b'"tracking":0.') + len(b'"tracking":0.')
        digit = b"1" if text[place : place + 1] != b"1" else b"2"
        return text[:place] + digit + text[place + 1 :]
    if how == "line":
        return text.replace(b"\n", b"\nnonsense\n", 3)
    if how == "other":
        return b'{"op_code": 0, "study_name": "x", "directions": [1], "worker_id": "a"}\n'
    return b""


@pytest.mark.parametrize("how", ["cut", "number", "line", "other", "empty"])
def test_a_damaged_store_is_refused_with_one_sentence(how: str, journal: Path) -> None:
    journal.write_bytes(edited(journal.read_bytes(), how))
    with pytest.raises(CorruptFile, match=r"a\.journal is no sound study: .+") as refused:
        Store.open(str(journal), write=True)
    assert "\n" not in str(refused.value)


def test_a_line_that_was_cut_as_it_was_written_is_removed(journal: Path) -> None:
    whole = journal.read_bytes()
    of, expected = study(trials=4), Store.open(str(journal)).trials()
    for cut in (1, 30, 200):
        journal.write_bytes(whole[:-cut])
        with Store.open(str(journal), write=True) as store:
            assert search(of, store) == expected
        assert Store.open(str(journal)).trials() == expected


def test_one_process_at_a_time_writes_and_any_reads(journal: Path) -> None:
    with Store.open(str(journal), write=True):
        with pytest.raises(InputError, match="another process writes"):
            Store.open(str(journal), write=True)
        assert len(Store.open(str(journal)).trials()) == 4
    with Store.open(str(journal), write=True) as store:
        assert len(store.trials()) == 4


def test_a_store_that_exists_is_not_begun_anew(journal: Path) -> None:
    with pytest.raises(InputError, match="which exists, must be a new file"):
        created(journal, study())
    with pytest.raises(InputError, match="must be a file of 'otolith study run'"):
        Store.open(str(journal.with_name("b.journal")))
