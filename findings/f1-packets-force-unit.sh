#!/bin/sh
# f1-packets 2026.1.1: the same field g_force_lateral is in g for F1 23 to 25, and in thousandths of g for F1 26.
#
# The game's UDP format of 2026 sends forces as whole numbers of 16 bits, in thousandths of g, instead of floats in
# g. The package follows the wire and keeps the name: `g_force_lateral` of the same 2 g to the left is -2.0 with
# 2025.1.1 and -2000 with 2026.1.1, and its own example and documents state no unit. Who upgrades, multiplies every
# force by a thousand. Each version also knows one year only: a packet of another year ends in a bare KeyError.
#
# Run by hand. Exits 0 while this holds, 1 once it does not.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for version in 2025.1.1 2026.1.1; do
    python3 -m venv "$folder/$version"
    "$folder/$version/bin/pip" install --quiet "f1-packets==$version"
done
cat > "$folder/read.py" <<'PYTHON'
import struct
import sys

from f1.packets import resolve


def motion(year: int) -> bytes:
    """2 g in the own car, number 0, as the format of that year writes it."""
    force, cars = (struct.pack("<3h", -2000, 0, 0), 24) if year == 2026 else (struct.pack("<3f", -2.0, 0.0, 0.0), 22)
    car = bytes(36) + force + bytes(12)
    header = struct.pack("<H5BQf2I2B", year, year - 2000, 1, 0, 1, 0, 1, 1.0, 1, 1, 0, 255)
    return header + car + bytes(len(car) * (cars - 1))


own = int(sys.argv[1])
print(resolve(motion(own)).car_motion_data[0].g_force_lateral)
try:
    resolve(motion(4051 - own))
    print("read")
except KeyError:
    print("KeyError")
PYTHON
old=$("$folder/2025.1.1/bin/python" "$folder/read.py" 2025 | tr '\n' ' ')
new=$("$folder/2026.1.1/bin/python" "$folder/read.py" 2026 | tr '\n' ' ')
echo "2 g: f1-packets 2025.1.1 says $old; 2026.1.1 says $new(its force, and what it makes of the other year)"
[ "$old" = "-2.0 KeyError " ] && [ "$new" = "-2000 KeyError " ]
