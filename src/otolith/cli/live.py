"""`otolith live`: motion platforms in real time, and what can be done without one."""

from otolith.cli.live_bench import bench
from otolith.cli.live_check import axis, check
from otolith.cli.live_log import export, replay
from otolith.cli.live_run import demo, run
from otolith.cli.live_virtual import faults
from otolith.cli.live_wire import emulate, learn_, record
from otolith.cli.output import group

app = group("Motion platforms in real time: drive one, play faults, record telemetry and learn its axes.")
app.command("run")(run)
app.command("demo")(demo)
app.command("check")(check)
app.command("axis")(axis)
app.command("record")(record)
app.command("learn")(learn_)
app.command("replay")(replay)
app.command("export")(export)
app.command("emulate")(emulate)
app.command("faults")(faults)
app.command("bench")(bench)


@app.callback()
def live() -> None:
    """Motion platforms in real time: drive one, play faults, record telemetry and learn its axes."""
