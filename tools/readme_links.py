"""The README as a package carries it: it is shown without the repository around it."""

import re
from pathlib import PurePosixPath

_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")


def absolute(text: str, address: str, version: str) -> str:
    """Return Markdown whose relative links lead to the repository's files of this version.

    Where no address is given, a link keeps its words and a picture is left out: a dead link is worse than
    none. A version of a commit without tag (`.dev`) leads to the branch `main`.
    """
    ref = "main" if "dev" in version or "+" in version else f"v{version}"

    def replaced(found: re.Match[str]) -> str:
        picture, words, target = found.groups()
        if re.match(r"[a-z]+:|#", target):
            return found[0]
        if not address:
            return "" if picture else words
        path = PurePosixPath(target).as_posix()
        return f"{picture}[{words}]({address}/{'raw' if picture else 'blob'}/{ref}/{path})"

    return _LINK.sub(replaced, text)
