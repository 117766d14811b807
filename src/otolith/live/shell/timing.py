"""What the processes of a session note about their own time, and hand over at their end."""

from dataclasses import dataclass, field

from otolith.live.core.times import Times


@dataclass(slots=True)
class OutputTiming:
    """How punctual an output was."""

    late: Times = field(default_factory=Times)  # of every wake-up, after its deadline
    work: Times = field(default_factory=Times)  # of every tick, from its wake-up until all is sent
    answer: Times = field(default_factory=Times)  # from a packet's arrival to the first set-point it is in
    skipped: int = 0  # ticks that nobody woke up for

    def sentences(self) -> list[str]:
        """Return it in words."""
        told = [f"{self.late.count} ticks, {self.skipped} skipped; woken late: {self.late}"]
        if self.answer.count:
            told.append(f"packet to set-point: {self.answer}; {self.answer.count} packets")
        return told


@dataclass(slots=True)
class ControllerTiming:
    """How long a controller took while the platform was cued."""

    cpu: Times = field(default_factory=Times)  # of a decision that answers a packet: CPU time
    plan: Times = field(default_factory=Times)  # from a packet's arrival to its published plan
    decisions: int = 0
    missed: int = 0  # periods in which a decision was not ready
    delay: str = ""  # of what is felt, in words

    def sentences(self) -> list[str]:
        """Return it in words."""
        if not self.decisions:
            return []
        told = f"{self.decisions} decisions, {self.missed} periods missed"
        return [f"{told}; packet to plan: {self.plan}; of this on the processor: {self.cpu}", self.delay]
