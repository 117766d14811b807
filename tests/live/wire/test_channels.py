"""Files that name channels: what is read from them, and what is refused before any packet comes."""

import json
import struct

import pytest

from otolith.core.errors import InputError
from otolith.live.wire.codemasters import custom
from otolith.live.wire.formats import WireError
from otolith.live.wire.wrc import KNOWN, wrc
from tests.live.wire.golden import CUSTOM_XML, WRC_CHANNELS, WRC_JSON, ea_wrc

BOTH = '<float channel="gforce_lateral"/><float channel="gforce_longitudinal"/>'


@pytest.mark.parametrize(
    ("xml", "words"),
    [
        ("no xml", "p.xml is no XML"),
        ("", "p.xml is no XML"),
        ("<other/>", "first element of p.xml is 'other', must be custom_udp"),
        ("<custom_udp/>", "channels of p.xml is without gforce_longitudinal"),
        (
            f"<custom_udp><flot channel='x'/>{BOTH}</custom_udp>",
            r"element 1 of p.xml is 'flot'.*did you mean float",
        ),
        (f"<custom_udp>{BOTH}<float/></custom_udp>", "element 3 of p.xml is channel ''"),
        (f"<custom_udp>{BOTH}<float channel='a' scale='0'/></custom_udp>", "a scale other than 0"),
        (f"<custom_udp>{BOTH}<float channel='a' scale='nan'/></custom_udp>", "a scale other than 0"),
        (f"<custom_udp>{BOTH}<float channel='gforce_lateral'/></custom_udp>", "named twice"),
        ("<custom_udp>" + 600 * "<float channel='a'/>" + "</custom_udp>", "channels of p.xml is 600"),
    ],
)
def test_a_wrong_xml_file_is_refused(xml: str, words: str):
    with pytest.raises(InputError, match=words):
        custom(xml, "p.xml")


def test_entities_are_refused_before_they_grow():
    bomb = '<!DOCTYPE custom_udp [<!ENTITY a "aaaaaaaaaa">'
    bomb += "".join(f'<!ENTITY a{n} "{10 * f"&a{n - 1 or str()};"}">' for n in range(1, 10)) + "]>"
    with pytest.raises(InputError, match=r"document type of p.xml is custom_udp, must be absent"):
        custom(bomb + "<custom_udp>&a9;</custom_udp>", "p.xml")


def test_without_a_vertical_force_it_is_zero():
    source = custom(CUSTOM_XML.replace('<float channel="gforce_vertical" scale="1.0"/>', ""), "p.xml")
    packet = b"moti" + struct.pack("<fI9f", 3.0, 0, 0.1, 0.2, 90.0, 0.0, 0.0, 72.0, 0.5, -0.25, 3.0)
    sample = source.parse(packet)
    assert sample.acceleration is not None
    assert sample.acceleration[2] == 0.0
    assert sample.acceleration[0] < 0.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "w.json is no JSON"),
        ("[]", "w.json is list, must be a JSON object"),
        ("{}", "packet 'session_update' of w.json is absent"),
        (WRC_JSON.replace("session_update", "session_end"), "packet 'session_update' of w.json is absent"),
        (
            WRC_JSON.replace("packet_uid", "packet_ui"),
            r"channel of w.json is 'packet_ui'.*did you mean packet_uid",
        ),
        (WRC_JSON.replace('"vehicle_acceleration_x", ', ""), "without vehicle_acceleration_x"),
        (WRC_JSON.replace("game_total_time", "packet_uid"), "each named once"),
        (WRC_JSON.replace('["packet_4cc"]', "3"), "not a list of names"),
    ],
)
def test_a_wrong_json_file_is_refused(text: str, words: str):
    with pytest.raises(InputError, match=words):
        wrc(text, "w.json")


def test_types_come_from_the_games_own_file():
    listed = [{"id": name, "type": KNOWN[name], "units": ""} for name in ("packet_4cc", *WRC_CHANNELS)]
    source = wrc(WRC_JSON, "w.json", channels=json.dumps({"channels": listed}))
    assert source.packet.size == ea_wrc().source.packet.size  # type: ignore[attr-defined]
    listed[2]["type"] = "float128"
    with pytest.raises(InputError, match=r"type of shiftlights_rpm_valid in channels.json is 'float128'"):
        wrc(WRC_JSON, "w.json", channels=json.dumps({"channels": listed}))


def test_mirrored_directions_are_refused():
    data = bytearray(ea_wrc().packet)
    struct.pack_into("<3f", data, 4 + 8 + 2 + 36 + 24, 0.0, -1.0, 0.0)  # up is down
    with pytest.raises(WireError, match=r"up direction of WRC packet .* about 1, a right-handed frame"):
        ea_wrc().source.parse(bytes(data))


def test_directions_that_are_none_are_refused():
    data = bytearray(ea_wrc().packet)
    struct.pack_into("<3f", data, 4 + 8 + 2 + 36, 0.0, 0.0, 0.0)
    with pytest.raises(WireError, match=r"length of left direction of WRC packet .* is 0, must be 1 within"):
        ea_wrc().source.parse(bytes(data))
