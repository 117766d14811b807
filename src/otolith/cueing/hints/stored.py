"""A hint as it is stored: what was learned offline, and the model to which it belongs.

A hint never changes an answer, but a hint for another platform or other weights costs time without use. So it
is tied to everything that determines the QP, and refused for any other problem.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any, Final

from numpy.typing import NDArray

from otolith.core.errors import CorruptFile, OtolithError
from otolith.core.frames import Dof
from otolith.cueing.hints.coarse import Coarse, CoarseLaws
from otolith.cueing.hints.features import braking_forms
from otolith.cueing.hints.network import Learned, Network
from otolith.cueing.hints.table import Table, Tabled
from otolith.cueing.mpc.guess import Hint
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import Platform

_SETTINGS: Final = (
    "horizon",
    "period",
    "control_weight",
    "washout",
    "braking",
    "terminal",
    "soft",
    "blocks",
    "firm",
    "later_penalty",
    "linear",
)
PARAMETERS: Final = 7  # number per pair: its states and the wanted force
Model = dict[str, Any]  # plain JSON values


class StaleHint(OtolithError):
    """A hint was made for another model."""


class Kind(StrEnum):
    """The kinds of hints in a stored hint."""

    LEARNED = "learned"
    LAW = "law"
    TABLE = "table"


def model_of(platform: Platform, pairs: Sequence[Dof], settings: MpcSettings) -> Model:
    """Return everything that the QP depends on, apart from state and reference."""
    limits = {pair.name: [asdict(one) for one in platform.limits(pair)] for pair in pairs}
    chosen = {"axes": [pair.name for pair in pairs]} | {name: getattr(settings, name) for name in _SETTINGS}
    objective = settings.objective
    chosen |= {"lag": settings.lag_on(platform)}
    chosen |= {"force weight": objective.force, "tracks what is sensed": objective.senses is not None}
    chosen |= {"washout": [asdict(weight) for weight in settings.washout], "soft": dict(settings.soft)}
    chosen |= {"circle": platform.circle, "limits": limits, "braking law": platform.braking.model_dump()}
    plain: Model = json.loads(json.dumps(chosen))
    return plain


def digest(model: Model) -> str:
    """Return the SHA-256 of a model."""
    return hashlib.sha256(json.dumps(model, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredHint:
    """All kinds of hints for one model."""

    model: Model
    training: dict[str, Any]  # how it was made: plain JSON values
    networks: tuple[Network, ...]  # one per pair
    table: Table
    laws: CoarseLaws

    def check(self, platform: Platform, pairs: Sequence[Dof], settings: MpcSettings) -> None:
        """Refuse another model.

        Raises
        ------
        StaleHint : the hint was made for another model; the message names the differences.
        """
        present = model_of(platform, pairs, settings)
        if present == self.model:
            return
        differ = [name for name in present if present[name] != self.model.get(name)]
        raise StaleHint(
            f"the hint is of model {digest(self.model)[:12]}, this is {digest(present)[:12]}: "
            f"they differ in {', '.join(differ)}"
        )

    def at_work(self, kind: Kind, platform: Platform, pairs: Sequence[Dof], settings: MpcSettings) -> Hint:
        """Return a new hint of one kind; errors are those of `check`."""
        self.check(platform, pairs, settings)
        if kind is Kind.LAW:
            return Coarse(self.laws, platform, pairs, settings)
        if kind is Kind.TABLE:
            return Tabled(self.table)
        shape = self.table.sets.shape[1:]
        return Learned(self.networks, braking_forms(platform, pairs), (shape[0], shape[1]))

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return what was learned, as plain arrays."""
        networks = {
            f"{_prefix(p)}{name}": array
            for p, network in enumerate(self.networks)
            for name, array in network.to_arrays().items()
        }
        return networks | self.table.to_arrays() | self.laws.to_arrays()

    @classmethod
    def from_arrays(
        cls, arrays: Mapping[str, NDArray[Any]], model: Model, training: dict[str, Any]
    ) -> "StoredHint":
        """Restore from plain arrays.

        Raises
        ------
        CorruptFile : an array is missing, or does not belong to the others.
        """
        try:
            hint = cls(
                model=model,
                training=training,
                networks=_networks(arrays),
                table=Table.from_arrays(dict(arrays)),
                laws=CoarseLaws.from_arrays(dict(arrays)),
            )
        except KeyError as error:
            raise CorruptFile(f"the hint lacks the array {error.args[0]}") from error
        except (ValueError, TypeError, IndexError) as error:
            raise CorruptFile(f"the hint is damaged: {error}") from error
        hint._check()
        return hint

    def _check(self) -> None:
        """Check that the parts fit the number of pairs, and that the table has all rows of the networks."""
        pairs, levels = len(self.model["axes"]), len(self.laws.levels)
        found = (len(self.networks), len(self.table.deviation), len(self.laws.parameters))
        if found != (pairs, PARAMETERS * pairs, levels * pairs) or pairs == 0:
            raise CorruptFile("the hint's networks, table or laws are not those of its model's axes")
        _, M, rows = self.table.sets.shape
        for network in self.networks:
            if not ((abs(network.outputs) >= 1) & (abs(network.outputs) <= M * rows)).all():
                raise CorruptFile("the hint's network names rows that its table does not have")


def _prefix(pair: int) -> str:
    """Return the prefix of the names of a pair's arrays."""
    return f"network-{pair}."


def _networks(arrays: Mapping[str, NDArray[Any]]) -> tuple[Network, ...]:
    """Return one network per pair; errors are those of `Network.from_arrays`."""
    pairs = len(arrays["table.deviation"]) // PARAMETERS
    parts = (
        {
            name.removeprefix(_prefix(p)): array
            for name, array in arrays.items()
            if name.startswith(_prefix(p))
        }
        for p in range(pairs)
    )
    networks = tuple(Network.from_arrays(part) for part in parts)
    if len({len(network.sizes) for network in networks}) > 1:
        raise ValueError("the networks differ in depth")
    return networks


@dataclass(frozen=True, slots=True)
class Refused:
    """A hint that was requested and cannot be used, with the reason."""

    reason: str
