"""Values as TOML writes them."""

import json
import re
from typing import Any, Final

# What JSON leaves as it is, but TOML refuses, or ends a line for whoever reads line by line.
_LEFT: Final = re.compile("[\x7f-\x9f\u2028\u2029]")


def toml_value(value: Any) -> str:
    """Return a text, number, truth value or list as it stands behind the sign of equality, in one line."""
    text = json.dumps(value, ensure_ascii=False)
    return _LEFT.sub(lambda found: f"\\u{ord(found[0]):04x}", text)
