"""A run that is still prepared, by a compiler that cannot be interrupted."""

import functools
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from otolith.cli.commander import listening, setup_for
from otolith.commander.job import Job, Maker
from otolith.commander.keeper import keep
from otolith.commander.security import Secrets
from tests.commander.client import Page
from tests.commander.test_server import LONG, QUICK


def never_ready(make: Maker, values: Any, tell: Callable[[str], None], name: str) -> Job:
    """Make a run; that of the scenario "stop" is compiled for ever."""
    while values["scenario"] == "stop":
        sum(range(1000))
    return make(values, tell, name)


def test_a_stop_does_not_wait_for_the_compiler(tmp_path: Path) -> None:
    with listening("127.0.0.1", 0) as line:
        made = setup_for(line, "127.0.0.1", tmp_path, Secrets())
        setup = replace(made, make=functools.partial(never_ready, made.make))
        said: list[str] = []
        over = threading.Event()
        keeper = threading.Thread(
            target=keep, args=(setup, said.append), kwargs={"on": lambda: not over.is_set()}
        )
        keeper.start()
        try:
            page = Page(setup.port)
            page.quiet()
            for _ in range(2):  # and again, with the process that was started anew
                with page.stream() as stream:
                    generation = page.run(**QUICK, scenario="stop")
                    stream.until("state", state="preparing", generation=generation)
                    assert page.say("stop") == 204
                    stream.until("event", text="stopped by hand while it was prepared")
                    assert not stream.until("state", state="stopped", generation=generation)["busy"]
                    stream.until("state", state="idle", generation=generation)
            with page.stream() as stream:
                generation = page.run(**LONG, speed=0.0)
                stream.until("done", generation=generation)
            assert said == []  # nothing died
        finally:
            over.set()
            keeper.join()
