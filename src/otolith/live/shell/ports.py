"""Who holds a UDP port: found in what Linux tells about sockets and processes."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

_TABLES: Final = ("udp", "udp6")  # of /proc/net
PROC: Final = Path("/proc")


def holders_of(port: int, proc: Path = PROC) -> list[str]:
    """Return the processes that hold a UDP port, as "name (process 123)"; empty if none can be seen.

    The processes of other users show their sockets only to root.
    """
    wanted = {f"socket:[{inode}]" for inode in _inodes(port, proc)}
    if not wanted:
        return []
    processes = sorted(proc.glob("[0-9]*"), key=lambda path: int(path.name))
    return [
        f"{_name(process)} (process {process.name})"
        for process in processes
        if wanted & set(_sockets(process))
    ]


def _inodes(port: int, proc: Path) -> Iterator[str]:
    """Yield the inodes of the sockets that are bound to a port.

    A row of /proc/net/udp is: number, local address in hexadecimal as ADDRESS:PORT, …, inode in column 10.
    """
    for table in _TABLES:
        path = proc / "net" / table
        if path.exists():
            for row in path.read_text().splitlines()[1:]:
                columns = row.split()
                if len(columns) > 9 and int(columns[1].rpartition(":")[2], 16) == port:
                    yield columns[9]


def _sockets(process: Path) -> Iterator[str]:
    """Yield what the descriptors of a process lead to."""
    try:
        for descriptor in (process / "fd").iterdir():
            yield str(descriptor.readlink())
    except OSError:  # it has ended, or is another user's
        return


def _name(process: Path) -> str:
    try:
        return (process / "comm").read_text().strip()
    except OSError:
        return "a process that has ended"
