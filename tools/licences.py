"""The licences of what is installed beside Otolith, read from a bill of materials, against a list.

    python tools/licences.py BILL.cdx.json [--extras]

A licence that is not on the list, or a package that states none, ends with exit code 1. What an extra brings
(`--extras`) may also have a licence of the second list: it is imported as it is, never copied or changed.
"""

import argparse
import json
import re
import sys
from pathlib import Path
from typing import Any, Final

PERMISSIVE: Final = {
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-CMU",
    "PSF-2.0",
    "Python-2.0",
    "Unlicense",
    "Zlib",
    "License :: OSI Approved :: Apache Software License",
    "License :: OSI Approved :: BSD License",
    "License :: OSI Approved :: MIT License",
    "License :: OSI Approved :: Python Software Foundation License",
}
OF_EXTRAS: Final = {
    "LGPL-3.0-only",
    "LGPL-3.0-or-later",
    "License :: OSI Approved :: GNU Lesser General Public License v3 (LGPLv3)",
    "License :: OSI Approved :: GNU Lesser General Public License v3 or later (LGPLv3+)",
    "MPL-2.0",
    "License :: OSI Approved :: Mozilla Public License 2.0 (MPL 2.0)",
}
READ: Final = {  # what the files LICENSE of packages say whose metadata do not say it in a usable form
    "FMPy": "BSD-2-Clause",
    "apsw": "Zlib",  # metadata: "any-OSI"
    "asttokens": "Apache-2.0",
    "casadi": "LGPL-3.0-or-later",
    "docutils": "BSD-2-Clause",  # one script for Emacs, which is not installed, is under the GPL
    "partd": "BSD-3-Clause",
    "ruckig": "MIT",
    "zstd": "BSD-2-Clause",
}
_WORD: Final = re.compile(r"\(|\)|\bAND\b|\bOR\b|[^\s()]+(?: WITH [^\s()]+)?")


def allowed(expression: str, known: set[str]) -> bool:
    """Whether an SPDX expression, or the name of a licence, can be met by licences that are known."""
    if expression in known:
        return True
    words = _WORD.findall(expression)
    left = _either(words, known)
    return left and not words


def _either(words: list[str], known: set[str]) -> bool:
    found = _both(words, known)
    while words and words[0] == "OR":
        words.pop(0)
        found = _both(words, known) or found
    return found


def _both(words: list[str], known: set[str]) -> bool:
    found = _single(words, known)
    while words and words[0] == "AND":
        words.pop(0)
        found = _single(words, known) and found
    return found


def _single(words: list[str], known: set[str]) -> bool:
    word = words.pop(0) if words else ""
    if word == "(":
        found = _either(words, known)
        return bool(words) and words.pop(0) == ")" and found
    return word in known


def stated(component: dict[str, Any]) -> list[str]:
    """Return the licences of a component, all of which apply: as its LICENSE says, or as it states."""
    if component["name"] in READ:
        return [READ[component["name"]]]
    licences = component.get("licenses", [])
    return [one.get("expression") or one["license"].get("id") or one["license"]["name"] for one in licences]


def refused(bill: dict[str, Any], known: set[str]) -> dict[str, str]:
    """Return the packages of a bill whose licence is not allowed, with what they state."""
    found = {one["name"]: stated(one) for one in bill["components"]}
    return {
        name: "; ".join(licences) or "none is stated"
        for name, licences in sorted(found.items())
        if not licences or not all(allowed(one, known) for one in licences)
    }


def main() -> None:
    """Print what is refused, and end with 1 if there is any."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bill", type=Path)
    parser.add_argument("--extras", action="store_true")
    given = parser.parse_args()
    bill = json.loads(given.bill.read_text(encoding="utf-8"))
    wrong = refused(bill, PERMISSIVE | OF_EXTRAS if given.extras else PERMISSIVE)
    for name, licences in wrong.items():
        print(f"{name}: {licences}")
    print(f"{len(bill['components'])} packages, {len(wrong)} with a licence that is not allowed")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
