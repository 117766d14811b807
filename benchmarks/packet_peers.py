"""Golden packets read by others: lfs-insim, f1-packets of four years, and pymavlink.

    python benchmarks/packet_peers.py

Installs each package from PyPI into a temporary folder of its own, because such packages may pin libraries
that we need newer, and compares what it reads of our hand-packed packets with what we read. Prints a line
per packet; exits with 1 if any number differs.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "src")]

import numpy as np  # noqa: E402
from tests.live.wire.golden import GOLDEN, G  # noqa: E402

from otolith.core.arrays import Vec  # noqa: E402
from otolith.live.devices.publisher import FIELDS, MESSAGE, MESSAGE_ID, SIGNS, Marsh  # noqa: E402
from otolith.live.messages import SetPoint, State  # noqa: E402

PEERS = {
    "lfs": ("lfs-insim==0.9.0",),
    "f1-2023": ("f1-packets==2023.1.0",),
    "f1-2024": ("f1-packets==2024.1.0",),
    "f1-2025": ("f1-packets==2025.1.1",),
    "f1-2026": ("f1-packets==2026.1.1",),
    "marsh": ("pymavlink==2.4.50",),
}
LFS = """
from lfs_insim.packets import OSO, OutSimPack, OutSimPack2
def read(name, data):
    if name.startswith("lfs2"):
        pack = OutSimPack2.unpack(data, OSO(int(name.partition("-")[2], 16)))
        main = pack.OSMain
    else:
        pack = main = OutSimPack.unpack(data)
    vectors = [[v.X, v.Y, v.Z] for v in (main.Accel, main.Vel, main.AngVel)]
    return {"vectors": vectors, "heading": main.Heading, "time": pack.Time, "id": pack.ID}
"""
F1 = """
from f1.packets import resolve
def read(name, data):
    pack = resolve(data)
    if "further" in name:
        velocity = [pack.local_velocity_x, pack.local_velocity_y, pack.local_velocity_z]
        return {"velocity": velocity, "rate": [getattr(pack, f"angular_velocity_{axis}") for axis in "xyz"]}
    car = pack.car_motion_data[pack.header.player_car_index]
    return {"force": [car.g_force_lateral, car.g_force_longitudinal, car.g_force_vertical]}
"""
MARSH = """
import subprocess, sys
made = ["--lang", "Python3", "--wire-protocol", "2.0", "-o", sys.argv[1] + "/marsh_state"]
tool = [sys.executable, "-m", "pymavlink.tools.mavgen", *made, sys.argv[1] + "/marsh.xml"]
subprocess.run(tool, check=True, capture_output=True)
sys.path.insert(0, sys.argv[1])
import io, marsh_state
def read(name, data):
    (message,) = marsh_state.MAVLink(io.BytesIO()).parse_buffer(data)
    return {key: getattr(message, key) for key in message.fieldnames}
"""
RUN = """
import json, sys
packets = json.load(open(sys.argv[1] + "/packets.json"))
print(json.dumps({name: read(name, bytes.fromhex(data)) for name, data in packets.items()}))
"""
SIX = np.array([0.5, -0.25, 0.125, 0.0625, -0.5, 0.75])


def marsh_xml() -> str:
    """Return the message's definition, with the fields in the order of the published XML."""
    order = [FIELDS[0], *FIELDS[-2:], *FIELDS[1:-2]]
    fields = "".join(f'<field type="{kind}" name="{name}">x</field>' for kind, name in order)
    message = f'<message id="{MESSAGE_ID}" name="{MESSAGE}"><description>x</description>{fields}</message>'
    head = '<?xml version="1.0"?><mavlink><version>3</version><dialect>0</dialect>'
    return f"{head}<messages>{message}</messages></mavlink>"


def set_point() -> SetPoint:
    return SetPoint(
        sequence=7,
        time_ns=1_234_000_000,
        pose=SIX,
        twist=2 * SIX,
        acceleration=-SIX,
        state=State.ENGAGED,
        token=1,
    )


def read_by(peer: str, folder: Path) -> dict[str, dict[str, list[float]]]:
    """Return what a peer reads of the packets that concern it."""
    packages = PEERS[peer]
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--target", str(folder / "site"), *packages]
    subprocess.run(install, check=True, capture_output=True)  # noqa: S603
    packets = {one.name: one.packet.hex() for one in GOLDEN if one.name.startswith(peer)}
    if peer == "marsh":
        packets = {"marsh": Marsh().packet(set_point()).hex()}
        (folder / "marsh.xml").write_text(marsh_xml())
    (folder / "packets.json").write_text(json.dumps(packets))
    text = {"lfs": LFS, "marsh": MARSH}.get(peer, F1) + RUN
    asked = [sys.executable, "-c", text, str(folder)]
    answer = subprocess.run(  # noqa: S603
        asked, check=True, capture_output=True, text=True, env={"PYTHONPATH": str(folder / "site")}
    )
    found: dict[str, dict[str, list[float]]] = json.loads(answer.stdout)
    return found


def differences(peer: str, found: dict[str, dict[str, list[float]]]) -> Iterator[tuple[str, float]]:
    """Yield for each packet the largest difference between the peer's numbers and ours."""
    ours = {one.name: one.source.parse(one.packet) for one in GOLDEN}
    for name, read in found.items():
        if peer == "marsh":
            expected = np.concatenate([SIGNS * SIX, 2 * SIGNS * SIX, -SIGNS * SIX])
            stated = np.array([read[field] for _, field in FIELDS[1:-2]], dtype=np.float64).ravel()
            yield name, _apart(stated, expected)
        elif peer == "lfs":
            sample, h = ours[name], float(np.asarray(read["heading"]))
            to_car = np.array([[-np.sin(h), np.cos(h), 0.0], [-np.cos(h), -np.sin(h), 0.0], [0.0, 0.0, 1.0]])
            stated = np.array(read["vectors"]) @ to_car.T  # X right, Y forward, Z up at heading zero
            pairs = zip(stated, (sample.acceleration, sample.velocity, sample.angular_rate), strict=True)
            yield name, max(_apart(a, _given(b)) for a, b in pairs)
        elif "further" in name:
            vx, vy, vz = read["velocity"]
            wx, wy, wz = read["rate"]
            stated = np.array([vz, vx, vy, wz, wx, wy])
            yield name, _apart(stated, np.r_[_given(ours[name].velocity), _given(ours[name].angular_rate)])
        else:
            size = 1e-3 * G if "2026" in name else G  # the package hands on the number of the wire
            lateral, longitudinal, vertical = np.array(read["force"]) * size
            yield name, _apart(np.array([longitudinal, -lateral, vertical]), _given(ours[name].acceleration))


def _given(one: Vec | None) -> Vec:
    assert one is not None  # noqa: S101
    return one


def _apart(a: Vec, b: Vec) -> float:
    return float(np.abs(a - b).max())


def main() -> None:
    worst = 0.0
    for peer, packages in PEERS.items():
        with tempfile.TemporaryDirectory() as folder:
            for name, apart in differences(peer, read_by(peer, Path(folder))):
                print(f"{packages[0]:22} {name:18} largest difference {apart:.1e}")
                worst = max(worst, apart)
    sys.exit(0 if worst < 1e-5 else 1)


if __name__ == "__main__":
    main()
