"""All runs that are stored in the Commander's folder, with their measures, for a page that compares them."""

import json
from pathlib import Path
from typing import Any, Final

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse

from otolith.commander.security import Refused
from otolith.commander.session import RESULTS, Session, count
from otolith.core.errors import CorruptFile, damage_reported

MOST: Final = 200  # runs that are listed, the newest
LARGEST: Final = 1 << 20  # [bytes] of a summary that is read
SUMMARY: Final = "summary.json"
REPORT: Final = "report.html"
ENDINGS: Final = (".html", ".h5", ".json")  # of results
# A report carries its own style and pictures, and needs nothing from anywhere.
_REPORT_POLICY: Final = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; "
    "frame-ancestors 'none'; sandbox allow-scripts"
)


def runs_routes(router: APIRouter, session: Session) -> None:
    """Add the routes of the page of all runs."""

    @router.get("/api/runs")
    def runs(request: Request) -> dict[str, Any]:
        count(request, session)
        return stored_runs(session.folder / RESULTS)

    @router.get("/api/runs/{folder}/{name}")
    def run_file(request: Request, folder: str, name: str) -> Response:
        count(request, session)
        return file_of(session.place(RESULTS, folder), name)


def stored_runs(folder: Path) -> dict[str, Any]:
    """Return what is stored: `runs`, the newest first, each with its `folder` and `summary`.

    `refused` has a sentence for every folder that cannot be read, `left_out` is the number of older ones.
    """
    found = [one for one in folder.iterdir() if (one / SUMMARY).is_file()] if folder.is_dir() else []
    found.sort(key=lambda one: (one / SUMMARY).stat().st_mtime, reverse=True)
    runs: list[dict[str, Any]] = []
    refused: list[str] = []
    for one in found[:MOST]:
        try:
            with damage_reported(f"{one.name}: its {SUMMARY} is none of a run"):
                runs += _runs_of(one)
        except CorruptFile as error:
            refused.append(str(error))
    return {"runs": runs, "refused": refused, "left_out": max(0, len(found) - MOST)}


def _runs_of(folder: Path) -> list[dict[str, Any]]:
    """Return the runs of one folder: one, or those of several algorithms."""
    path = folder / SUMMARY
    if path.stat().st_size > LARGEST:
        raise ValueError("too large")
    read = json.loads(path.read_text(encoding="utf-8"))
    summaries = [read] if "scenario" in read else read.values()  # of one run, or of several by algorithm
    time = path.stat().st_mtime
    return [
        {
            "folder": folder.name,
            "time": time,
            "files": files_of(folder),
            "summary": {name: value for name, value in one.items() if name != "settings"},
            **{name: str(one[name]) for name in ("scenario", "cueing", "platform")},
        }
        for one in summaries
    ]


def files_of(folder: Path) -> list[str]:
    """Return the names of the results in a folder; none if there is none."""
    return sorted(path.name for path in folder.iterdir() if path.suffix in ENDINGS) if folder.is_dir() else []


def file_of(folder: Path, name: str) -> Response:
    """Return a file of results.

    Raises
    ------
    Refused : there is none of this name.
    """
    if name not in files_of(folder):
        raise Refused(404, "there is no such result")
    headers = {"content-security-policy": _REPORT_POLICY} if name == REPORT else saved(name)
    return FileResponse(folder / name, headers=headers)


def saved(name: str) -> dict[str, str]:
    """Return the headers of a file that a browser saves."""
    return {"content-disposition": f'attachment; filename="{name}"'}
