"""JSON logs in the forms that people keep, and JSON that is no log."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from otolith.core.errors import InputError
from otolith.recordings import Log, log_from
from otolith.recordings.jsonlog import looks_like_json, parse_json

T = np.round(np.arange(0.0, 4.0, 0.05), 3)
AX = np.round(np.sin(T), 6)
RECORDS = [{"time": t, "ax": a} for t, a in zip(T.tolist(), AX.tolist(), strict=True)]


def read(document: object, **columns: str) -> Log:
    text = document if isinstance(document, str) else json.dumps(document)
    assert looks_like_json(text)
    return log_from(parse_json(text, "log.json"), columns=columns)


@pytest.mark.parametrize(
    "document",
    [
        RECORDS,
        json.dumps(RECORDS, indent=2),
        "\n".join(json.dumps(one) for one in RECORDS),
        "\n\n".join(json.dumps(one) for one in RECORDS) + "\n",
        {"time": T.tolist(), "ax": AX.tolist()},
        {"about": {"driver": "nobody", "laps": [1, 2]}, "data": RECORDS},
        {"session": {"samples": {"time": T.tolist(), "ax": AX.tolist()}}},
        [["time", "ax"], *[[t, a] for t, a in zip(T.tolist(), AX.tolist(), strict=True)]],
        [{"time": one["time"], "imu": {"acc": {"x": one["ax"]}}} for one in RECORDS],
        [{"time": one["time"], "acc": [one["ax"], 0.0, 0.0]} for one in RECORDS],
        [{"time": str(one["time"]), "ax": str(one["ax"])} for one in RECORDS],
        [{"timestamp": round(1.7e12 + 1000 * one["time"]), "ax": one["ax"]} for one in RECORDS],
    ],
)
def test_a_drive_is_read_from_every_form(document: object) -> None:
    log = read(document)
    assert_allclose(log.t, T, atol=1e-9)
    assert_allclose(log.force[:, 0], AX, atol=1e-12)


def test_what_a_record_lacks_is_blank() -> None:
    seldom = [one if i % 2 else {"time": one["time"], "speed": 7.0} for i, one in enumerate(RECORDS)]
    log = read(seldom)
    assert_allclose(log.channels["ax"].t[:3], [0.0, 0.1, 0.2], atol=1e-9)
    assert len(log.channels["vx"].t) == len(T) // 2


def test_tables_of_several_sensors_keep_their_clocks() -> None:
    slow = [{"time": t, "z": 0.1} for t in T[::4].tolist()]
    fast = [{"time": one["time"], "x": one["ax"]} for one in RECORDS]
    apart = {"Accelerometer": fast, "Gyroscope": slow}
    mixed = [{"sensor": name, **record} for name, some in apart.items() for record in some]
    for document in (apart, mixed):
        log = read(document)
        assert_allclose(log.channels["ax"].values, AX)
        assert_allclose(log.channels["yaw_rate"].t, T[::4], atol=1e-9)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('{"a": 1', "line 1 of log.json is no JSON"),
        ('[{"a": 1},\n{"a": oops}]', "line 2 of log.json is no JSON"),
        ('{"t": 1, "ax": 2}\n{"t": 2, "ax": }\n', "line 2 of log.json is no JSON"),
        ('{"type": "FeatureCollection", "features": [{"a": 1}, {"a": 2}]}', "log.json is GeoJSON"),
        ('{"a": {"b": 1}}', "log.json is JSON without a table"),
        ("[" * 100000, "log.json is JSON nested too deeply"),
        ("[]", "log.json is JSON without a table"),
    ],
)
def test_what_is_no_log_is_refused_as_what_it_is(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_json(text, "log.json")
    assert str(caught.value).startswith(sentence)


def test_a_section_of_another_format_is_no_json() -> None:
    assert not looks_like_json("[header]\ntime\n[data]\n")
    assert not looks_like_json("t,ax\n0,1\n")


def test_a_name_that_comes_late_is_blank_before() -> None:
    records: list[dict[str, float]] = [{"t": 0.1 * k, "ax": 1.0 + k} for k in range(6)]
    records[4]["ay"], records[5]["ay"] = 4.0, 5.0
    read = parse_json(json.dumps(records), "late.json")
    assert read.names == ("t", "ax", "ay")
    assert_array_equal(read.values[2], [np.nan] * 4 + [4.0, 5.0])
