"""Settings by name: what a study varies, how a design is changed by it, and the options that do the same.

| name | sets | option of `otolith run` |
|---|---|---|
| `liveliness`, `period`, `control_weight`, `braking`, `solver` | that option | `--liveliness` … |
| `blocks`, or `horizon` with `block_count` | the blocks of constant inputs | `--blocks` |
| `horizon` alone | steps of the horizon, without blocks | `--horizon` |
| `weight.STATE` | a constant washout weight | `--weight STATE=…` |
| `soft.ROW` | the penalty of a soft row | `--soft ROW=…` |
| `prediction`, `prediction.FIELD` | a prediction and its parameters (alone: of `adaptive`) | `--prediction` |
| `tuning`, `tuning.TABLE.FIELD` | a tuning, by default the platform's, and its values | `--tuning FILE` |
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np
from pydantic import ValidationError

from otolith import registry
from otolith.core.errors import InputError, one_of
from otolith.cueing.design import Design
from otolith.cueing.mpc.rows import parse_braking_rows
from otolith.cueing.mpc.washout_weights import constant
from otolith.cueing.prediction import parse_prediction
from otolith.cueing.washout.tuning import Tuning, load_tuning
from otolith.platforms.validation_messages import sentence

Settings = Mapping[str, float | int | str]

# Settings by name, with the option of the registry that an algorithm must read to be changed by them.
_PLAIN: Final = {
    "liveliness": "liveliness",
    "period": "period",
    "control_weight": "control_weight",
    "braking": "braking",
    "solver": "solver",
    "horizon": "horizon",
    "blocks": "blocks",
    "block_count": "blocks",
    "prediction": "prediction",
    "tuning": "tuning",
}
_GROUPS: Final = {"weight": "weight", "soft": "soft", "prediction": "prediction", "tuning": "tuning"}


def check_names(cueing: str, names: Iterable[str]) -> None:
    """Refuse a setting that does not exist, or that an algorithm does not read.

    Raises
    ------
    InputError : there is such a setting, or no such algorithm.
    """
    reads = registry.cueing_named(cueing).reads
    for name in names:
        group, dot, _ = name.partition(".")
        option = _GROUPS.get(group) if dot else _PLAIN.get(name)
        known = [*_PLAIN, *(f"{one}.…" for one in _GROUPS)]
        if option is None:
            raise InputError("parameter", repr(name), one_of(known, name))
        if option not in reads:
            raise InputError("parameter", repr(name), f"left out: {cueing} does not read it")


def applied(design: Design, settings: Settings) -> Design:
    """Return the design with these settings changed.

    Raises
    ------
    InputError : a value is refused.
    """
    mpc: dict[str, Any] = {}
    for name in ("period", "control_weight"):
        if name in settings:
            mpc[name] = float(settings[name])
    if "solver" in settings:
        mpc["engine"] = registry.lookup(registry.SOLVERS, "solver", str(settings["solver"])).load()
    explicit = design.explicit
    if "braking" in settings:
        mpc["braking"] = parse_braking_rows(str(settings["braking"]))
        explicit = replace(explicit, braking=mpc["braking"])
    if "horizon" in settings or "blocks" in settings:
        blocks = _blocks(settings)
        mpc |= {"blocks": blocks, "horizon": sum(blocks) or int(settings["horizon"])}
    if weights := _group(settings, "weight"):
        mpc["washout"] = constant({state: float(value) for state, value in weights.items()})
    if soft := _group(settings, "soft"):
        mpc["soft"] = {row: float(value) for row, value in soft.items()}
    if (text := _prediction(settings)) is not None:
        mpc["prediction"] = parse_prediction(text)
    return replace(
        design,
        mpc=replace(design.mpc, **mpc),
        explicit=explicit,
        liveliness=float(settings.get("liveliness", design.liveliness)),
        washout=tuning_of(design, settings) or design.washout,
    )


def options(settings: Settings) -> list[str]:
    """Return the options of `otolith run` that do what `applied` does, but for `--tuning FILE`."""
    words = [
        f"--{name.replace('_', '-')} {_text(settings[name])}"
        for name in ("liveliness", "period", "control_weight", "solver", "braking")
        if name in settings
    ]
    if "horizon" in settings or "blocks" in settings:
        blocks = _blocks(settings)
        words.append(
            f"--blocks {','.join(map(str, blocks))}" if blocks else f"--horizon {settings['horizon']}"
        )
    for group in ("weight", "soft"):
        words += [f"--{group} {name}={_text(value)}" for name, value in _group(settings, group).items()]
    if (text := _prediction(settings)) is not None:
        words.append(f"--prediction {text}")
    return words


def tuning_of(design: Design, settings: Settings) -> Tuning | None:
    """Return the tuning of the washouts with these settings; None if they set nothing of it.

    Raises
    ------
    InputError : there is no such value in the tuning, or it is refused.
    """
    changes = _group(settings, "tuning")
    if not changes and "tuning" not in settings:
        return None
    base = load_tuning(str(settings["tuning"])) if "tuning" in settings else design.tuning
    fields = base.model_dump()
    for path, value in changes.items():
        *tables, last = path.split(".")
        table = fields
        for name in tables:
            table = table.get(name) if isinstance(table, dict) else None  # type: ignore[assignment]
        if not isinstance(table, dict) or last not in table or isinstance(table[last], dict):
            raise InputError("parameter", f"'tuning.{path}'", f"a value of tuning {base.name}")
        table[last] = value
    try:
        return Tuning.model_validate(fields)
    except ValidationError as error:
        raise sentence(error, Tuning, f"tuning {base.name} as varied") from None


def spread(horizon: int, count: int) -> tuple[int, ...]:
    """Return the lengths of blocks that grow geometrically from 1, 1 to fill a horizon.

    Parameters
    ----------
    horizon : N, number of steps.
    count : number of blocks; if it is at least N, every step is one.

    Raises
    ------
    InputError : there are fewer than three blocks.
    """
    if count < 3:
        raise InputError("block_count", count, "at least 3")
    if count >= horizon:
        return (1,) * horizon
    ends = np.unique(np.round(np.geomspace(2.0, float(horizon), count - 1)).astype(int))
    return 1, *sorted(int(length) for length in np.diff([1, *ends]))


def _blocks(settings: Settings) -> tuple[int, ...]:
    if "blocks" in settings:
        texts = str(settings["blocks"]).split(",")
        if not all(text.strip().isdecimal() for text in texts):
            raise InputError("blocks", repr(settings["blocks"]), "numbers of steps with commas")
        return tuple(map(int, texts))
    if "block_count" in settings:
        return spread(int(settings["horizon"]), int(settings["block_count"]))
    return ()


def _prediction(settings: Settings) -> str | None:
    """Return the text of `--prediction`."""
    fields = _group(settings, "prediction")
    if not fields and "prediction" not in settings:
        return None
    name = str(settings.get("prediction", "adaptive"))
    given = ",".join(f"{field}={_text(value)}" for field, value in fields.items())
    return f"{name}{',' if ':' in name else ':'}{given}" if given else name


def _group(settings: Settings, group: str) -> dict[str, float | int | str]:
    start = f"{group}."
    return {name.removeprefix(start): value for name, value in settings.items() if name.startswith(start)}


def _text(value: float | int | str) -> str:
    return repr(value) if isinstance(value, float) else str(value)
