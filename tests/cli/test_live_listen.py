"""Words on standard input: every line is a sign of life, and an empty one is nothing else."""

import os
import sys

import pytest

from otolith.cli.live_run import _listen
from otolith.live.messages import Word


class Spoken:
    """Takes words and signs in place of a session."""

    def __init__(self) -> None:
        self.words: list[Word] = []
        self.signs = 0

    def say(self, *words: Word) -> None:
        self.words += words

    def sign(self) -> None:
        self.signs += 1


def test_lines_are_signs_of_life_and_words(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    reading, writing = os.pipe()
    live = Spoken()
    with os.fdopen(reading) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        for line, words in (("arm\n", [Word.ARM]), ("\n", [Word.ARM]), ("armm\n", [Word.ARM])):
            os.write(writing, line.encode())
            assert _listen(live)  # type: ignore[arg-type]
            assert live.words == words
        assert live.signs == 3
        assert "'armm' is no word: arm, engage" in capsys.readouterr().err
        os.close(writing)
        assert not _listen(live)  # type: ignore[arg-type]
