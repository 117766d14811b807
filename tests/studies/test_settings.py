"""Settings change a design as the options of the command line do."""

import shlex
from typing import Any

import pytest
import typer

from otolith.cli.app import program
from otolith.cli.options import RunOptions
from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design
from otolith.cueing.washout.tuning import parse_tuning
from otolith.platforms import load
from otolith.record import design_to_record
from otolith.studies.export import toml, tuning_text
from otolith.studies.settings import applied, options, spread

SETTINGS: dict[str, dict[str, Any]] = {
    "weights": {"weight.position": 0.1234567890123, "weight.velocity": 2, "control_weight": 3.3e-05},
    "blocks": {"blocks": "1,2,3,4", "braking": "leading"},
    "growing blocks": {"horizon": 60, "block_count": 6, "prediction.near": 1.1},
    "horizon": {"horizon": 60, "period": 0.02, "solver": "dense", "soft.tilt_rate": 50.0},
    "prediction": {"prediction": "decay:time=0.7", "liveliness": 0.25},
}


def parsed(words: list[str]) -> RunOptions:
    """What `otolith run` makes of options."""
    command: Any = typer.main.get_command(program("run")).commands["run"]  # type: ignore[attr-defined]
    context = command.make_context("run", ["sine-1", *words])
    names = RunOptions.__dataclass_fields__
    return RunOptions(**{name: value for name, value in context.params.items() if name in names})


@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
def test_the_options_of_settings_make_the_same_design(settings: dict[str, Any]) -> None:
    made = applied(Design(platform=load("thesis"), dofs=(SURGE_PITCH,)), settings)
    same = parsed(shlex.split(" ".join(options(settings)))).design()
    assert design_to_record(made) == design_to_record(same)
    assert design_to_record(made) != design_to_record(Design(platform=load("thesis"), dofs=(SURGE_PITCH,)))


def test_a_tuning_of_settings_is_read_as_it_was_made() -> None:
    design = Design(platform=load("davsi"), dofs=(SURGE_PITCH,))
    settings = {"tuning.classical.surge.natural_radps": 2.3456789, "tuning.scaling.force.slope": 0.3}
    made = applied(design, settings).tuning
    read = parse_tuning(tuning_text(design, settings, made.description), "made.toml")
    assert read == made
    assert made.classical is not None
    assert made.classical.surge.natural_radps == 2.3456789
    assert design.tuning.scaling != made.scaling
    for wrong in ("tuning.classical.surge", "tuning.classical.surge.speed", "tuning.surge.damping"):
        with pytest.raises(InputError, match=f"is '{wrong}', must be a value of tuning davsi"):
            applied(design, {wrong: 1.0})
    with pytest.raises(InputError, match="damping in tuning davsi as varied is 9"):
        applied(design, {"tuning.classical.surge.damping": 9.0})


def test_blocks_that_grow_fill_the_horizon() -> None:
    for horizon in (20, 50, 150, 200):
        for count in (3, 7, 9, 14):
            lengths = spread(horizon, count)
            assert sum(lengths) == horizon
            assert len(lengths) <= count
            assert lengths[:2] == (1, 1)
            assert sorted(lengths) == list(lengths)
    assert spread(4, 9) == (1, 1, 1, 1)
    with pytest.raises(InputError, match="block_count is 2"):
        spread(20, 2)


def test_toml_keeps_names_with_dots_and_words_with_quotes() -> None:
    import tomllib

    fields = {"a": {"b.c": 1.5, "d": {"e": 2}}, "f": 'say "x" \\ y', "g": {"h": {"i": 1e-07}}}
    assert tomllib.loads(toml(fields)) == fields
