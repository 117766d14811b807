"""What the Commander's page costs in a browser: CPU per drawn frame, frames per second, bytes, and memory.

    python benchmarks/commander_page.py [--seconds 15] [--size 1280x720] [--json FILE]

The page shows a run of a real Commander (`classical` in two degrees of freedom; 30 frames per second, four
plots and the hexapod) in the system's chromium, headless, which draws in software. Bytes are those of the
websocket's messages, before masks and heads of its frames. CPU is that of all of chromium's
processes together, from /proc; frames are counted by the page's own animation clock as those in which a plot
was drawn. Frames per second measure the neighbours of a busy machine too, CPU per frame does not.

Memory is that of the page's live objects after a collection of garbage, and the resident memory of the
Commander's processes. It is read once a minute; `--seconds 3540` shows whether an hour leaves anything
behind, which is as long as the longest run. The ring of samples in shared memory (7 MB) becomes resident
while it is filled for the first time, which takes 65 s: slopes are those after that.
"""

import argparse
import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path
from typing import Final

import numpy as np
from playwright.sync_api import Page, sync_playwright

PROGRAM: Final = "import sys; from otolith.cli import main; main(sys.argv[1:])"
DRIVE: Final = "sine:amplitude=0.5,frequency=0.2,duration={:g}"
MINUTE, LONGEST = 60.0, 3600.0  # [s] of a minute, and of the longest run
PROCESSES: Final = ("server", "simulation", "rig")  # of the Commander, in the order of their start
COUNT: Final = """() => {
  const draw = CanvasRenderingContext2D.prototype.clearRect;
  window.drawn = 0;
  CanvasRenderingContext2D.prototype.clearRect = function (...box) {
    if (this.canvas.id === "hexapod") window.drawn += 1;
    return draw.apply(this, box);
  };
}"""
WEIGHT: Final = """() => {
  const all = [performance.getEntriesByType("navigation")[0], ...performance.getEntriesByType("resource")];
  const first = performance.getEntriesByName("first-contentful-paint")[0];
  return [all.reduce((sum, one) => sum + one.transferSize, 0), first ? first.startTime : NaN];
}"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=15.0)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--json", type=Path, help="File for the rows of the table of speed.")
    given = parser.parse_args()
    if not 0.0 < given.seconds <= LONGEST - MINUTE:
        parser.error(f"--seconds is {given.seconds:g} s, must be above 0 and at most {LONGEST - MINUTE:g} s")
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("there is no chromium here")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with tempfile.TemporaryDirectory(prefix="otolith-") as folder:
        command = [sys.executable, "-c", PROGRAM, "commander", "--port", str(port), "--folder", folder]
        server = subprocess.Popen(command, stdout=subprocess.DEVNULL)  # noqa: S603 (our own program)
        try:
            wait_for(f"http://127.0.0.1:{port}/")
            rows = measure(chromium, f"http://127.0.0.1:{port}/", given.seconds, given.size, server.pid)
        finally:
            server.terminate()
            server.wait()
    if given.json is not None:
        given.json.write_text(json.dumps(rows, indent=2) + "\n", encoding="utf-8")


def wait_for(address: str) -> None:
    for _ in range(600):
        try:
            urllib.request.urlopen(f"{address}health").close()  # noqa: S310 (our own address)
            return
        except OSError:
            time.sleep(0.1)
    sys.exit("the server does not answer")


def measure(
    chromium: str, address: str, seconds: float, size: str, commander: int
) -> list[dict[str, object]]:
    width, height = map(int, size.split("x"))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": width, "height": height})
        came: list[int] = []  # lengths of the messages of the websocket
        page.on("websocket", lambda line: line.on("framereceived", lambda text: came.append(len(text))))
        page.goto(address, wait_until="load")
        page.wait_for_selector("#run:enabled")
        weight, paint = page.evaluate(WEIGHT)
        page.select_option("#field-cueing", "classical")
        page.fill("#field-scenario", DRIVE.format(seconds + MINUTE))
        page.keyboard.press("Tab")
        page.wait_for_selector("#run:enabled")
        page.click("#run")
        page.wait_for_selector(".panel", timeout=120_000)
        page.evaluate(COUNT)
        page.wait_for_timeout(3_000)
        memory, at = [memory_of(page, commander)], [0.0]
        came.clear()
        before, frames, begun = cpu_of_children(), page.evaluate("window.drawn"), time.monotonic()
        while (left := begun + seconds - time.monotonic()) > 0.0:
            page.wait_for_timeout(1e3 * min(left, MINUTE))
            memory.append(memory_of(page, commander))
            at.append(time.monotonic() - begun)
            if seconds > MINUTE:
                print(f"{at[-1]:6.0f} s  {as_text(memory[-1])}", flush=True)
        after, frames_then, ended = cpu_of_children(), page.evaluate("window.drawn"), time.monotonic()
        received = sum(came) / (ended - begun)
        browser.close()
    drawn, used = frames_then - frames, after - before
    load = os.getloadavg()[0]
    rate, cost = drawn / (ended - begun), 1e3 * used / drawn
    print(f"{size}: {rate:.1f} frames/s, {cost:.1f} ms CPU per frame (load {load:.1f})")
    print(f"page: {weight / 1e3:.0f} kB on the wire, first paint after {paint / 1e3:.2f} s")
    print(f"stream: {received / 1e3:.1f} kB/s")
    print(f"memory at the start: {as_text(memory[0])}")
    print(f"memory at the end:   {as_text(memory[-1])}")
    if seconds >= 5.0 * MINUTE:
        print(f"slope per hour:      {as_text(slopes(memory, at))}")
    return [
        {"what": "stream of the page", "now": received / 1e3, "unit": "kB/s", "goal": "20"},
        {"what": "CPU of the browser per frame", "now": cost, "unit": "ms", "goal": "30"},
        {"what": "page on the wire", "now": weight / 1e3, "unit": "kB", "goal": "300"},
    ]


def memory_of(page: Page, commander: int) -> dict[str, float]:
    """Memory [MB] of the page's objects, and of each process of the Commander."""
    children = sorted(child for child, parent in parents_of().items() if parent == commander)
    spawned = [child for child in children if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()]
    processes = dict(zip(PROCESSES, spawned, strict=True))
    return {"page": heap_of(page) / 1e6} | {name: resident(process) for name, process in processes.items()}


def resident(process: int) -> float:
    """Resident memory [MB] of a process."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def slopes(memory: list[dict[str, float]], at: list[float]) -> dict[str, float]:
    """Slope [MB/h] of each series by least squares, from the second minute on; `at` in seconds."""
    hours = np.array(at[2:]) / 3600.0
    return {name: float(np.polyfit(hours, [one[name] for one in memory[2:]], 1)[0]) for name in memory[0]}


def as_text(memory: dict[str, float]) -> str:
    return ", ".join(f"{name} {figure:.1f} MB" for name, figure in memory.items())


def heap_of(page: Page) -> float:
    """Bytes of all live objects of the page, typed arrays included, after a collection of garbage."""
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    usage = session.send("Runtime.getHeapUsage")
    session.detach()
    return float(usage["usedSize"]) + float(usage.get("backingStorageSize", 0.0))


def cpu_of_children() -> float:
    """CPU time [s] of all processes below this one that are chromium's."""
    parents, used = parents_of(), {}
    for process in parents:
        try:
            text = Path(f"/proc/{process}/stat").read_text()
        except OSError:  # it ended meanwhile
            continue
        name, fields = text.split("(", 1)[1].rsplit(")", 1)[0], text.rsplit(")", 1)[1].split()
        if name.startswith("chrom"):
            used[process] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return sum(cpu for process, cpu in used.items() if below(process, parents))


def parents_of() -> dict[int, int]:
    """The parent of every process."""
    parents = {}
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit():
            continue
        try:
            text = (folder / "stat").read_text()
        except OSError:  # it ended meanwhile
            continue
        parents[int(folder.name)] = int(text.rsplit(")", 1)[1].split()[1])
    return parents


def below(process: int, parents: dict[int, int]) -> bool:
    while process in parents:
        process = parents[process]
        if process == os.getpid():
            return True
    return False


if __name__ == "__main__":
    main()
