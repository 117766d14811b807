"""`otolith live run` while it starts: what pages say then."""

import contextlib
import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest

from otolith.cli import live_run
from otolith.cli.live_run import Choices, drive
from otolith.live.messages import State, Word
from otolith.live.session import Session
from otolith.live.shell import supervise
from otolith.live.shell.timed import NotEngaged, cued_for


def idle_session() -> Session:
    return Choices(
        incoming="generic+udp://127.0.0.1:9109",
        outgoing="generic+udp://127.0.0.1:9119",
        cueing="classical",
        tuning="davsi",
    ).session()


class Starting:
    """A session that is asked something while it starts, and whose output then ends."""

    fault = ""

    def __init__(self, said: list[Word]) -> None:
        self.said, self.looks = said, 0

    def start(self, meanwhile: Callable[[], None]) -> None:
        meanwhile()

    def alive(self, _: str) -> bool:
        self.looks += 1
        return self.looks < 2

    def look(self) -> None:
        """Have nothing to tell."""

    def say(self, *words: Word) -> None:
        self.said.extend(words)

    def sign(self) -> None:
        """Need no sign of life."""

    def end(self) -> None:
        """Have nothing to end."""


class Pages:
    """Pages that say words in turn, and see sentences."""

    def __init__(self, *turns: tuple[Word, ...]) -> None:
        self.turns, self.told = list(turns), list[str]()

    def words(self, _: Callable[[str], None]) -> tuple[Word, ...]:
        return self.turns.pop(0) if self.turns else ()

    def tell(self, sentence: str) -> None:
        self.told.append(sentence)


@pytest.mark.parametrize(
    ("early", "later", "seconds", "said"),
    [
        ((Word.ARM, Word.STOP), (), 600.0, []),  # it would arm by itself
        ((Word.ARM,), (Word.STOP,), 600.0, [Word.STOP]),
        ((Word.STOP,), (Word.ARM,), None, [Word.ARM]),
    ],
)
def test_what_pages_say_while_a_session_starts_is_answered_and_not_carried_out(
    early: tuple[Word, ...],
    later: tuple[Word, ...],
    seconds: float | None,
    said: list[Word],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pages = Pages(early, later)

    @contextlib.contextmanager
    def pages_of(*_: Any) -> Iterator[Pages]:
        yield pages

    monkeypatch.setattr(live_run, "pages_of", pages_of)
    monkeypatch.setattr(live_run, "_listen", lambda _: True)
    heard: list[Word] = []
    monkeypatch.setattr(supervise, "Live", lambda *_, **__: Starting(heard))
    drive(idle_session(), seconds, page=0)
    assert heard == said
    answered = [f"{word}: the session is still starting, and nothing moves" for word in early]
    assert [text for text in pages.told if "still starting" in text] == answered


class Waiting(Starting):
    """A session that gets no further than a state."""

    def __init__(self, state: State | None) -> None:
        super().__init__([])
        self.state = state

    def alive(self, _: str) -> bool:
        self.looks += 1
        return self.looks < 50  # far more than it may need

    def look(self) -> State | None:  # type: ignore[override]
        return self.state


@pytest.mark.parametrize(
    ("state", "word"),
    [(State.IDLE, Word.ARM), (State.READY, Word.ENGAGE), (State.CHECKING, None), (None, None)],
)
def test_a_session_that_is_cued_for_a_time_ends_where_it_does_not_engage(
    state: State | None, word: Word | None
) -> None:
    live, clock = Waiting(state), itertools.count(0.0, 10.0)
    with pytest.raises(NotEngaged, match=f"the session is {state or 'silent'} after 60 s, must be engaged"):
        cued_for(live, 5.0, lambda: None, now=lambda: next(clock))  # type: ignore[arg-type]
    assert set(live.said) == ({word} if word else set())
    assert next(clock) <= 100.0


def test_a_session_that_may_not_arm_is_not_cued_for_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(supervise, "Live", None)  # nothing starts
    untested = replace(idle_session(), forbids="its axes are not tested")
    with pytest.raises(NotEngaged, match=r"so not be cued for 5 s: its axes are not tested"):
        drive(untested, 5.0)
