"""The page inside an FMU, `documentation/index.html`: what it does, when, and all that goes in and out."""

from html import escape

from otolith import __version__
from otolith.export.fmu_description import Version, unit_name
from otolith.export.program import Port, Program


def page(program: Program, version: Version) -> str:
    """Return the text of the page."""
    return f"""\
<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{escape(program.name)}</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 52em; margin: 2em auto; padding: 0 1em; }}
td, th {{ text-align: left; padding: 0.2em 1em 0.2em 0; vertical-align: top; }} th {{ white-space: nowrap; }}
</style></head>
<body>
<h1>{escape(program.name)}</h1>
<p>Motion cueing by Otolith {__version__}, as an FMU for co-simulation (FMI {version}). It decides once per
{1e3 * program.period:g} ms. The host may communicate at any other step: a longer one contains several
decisions, a shorter one a part of the time between two. A decision reads the inputs that were set last before
it.</p>
<p>Axes: x forward, y left, z up; roll, pitch and yaw about them. Units are SI; angles are in radians.</p>
<h2>Inputs</h2>
{_table(program.inputs)}
<h2>Outputs</h2>
{_table(program.outputs)}
<p>There are no parameters: limits, weights and filters are compiled in, since they were designed together.
Export the FMU again to change one.</p>
</body>
</html>
"""


def _table(ports: tuple[Port, ...]) -> str:
    rows = "\n".join(
        f"<tr><td><code>{escape(port.name)}</code></td><td>{escape(unit_name(port.unit))}</td>"
        f"<td>{escape(port.meaning)}</td><td>{port.start:g}</td></tr>"
        for port in ports
    )
    return f"<table>\n<tr><th>name</th><th>unit</th><th>meaning</th><th>at rest</th></tr>\n{rows}\n</table>"
