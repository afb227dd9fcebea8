"""The messages of a page are bounded before anything reads them."""

import contextlib
import json

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from portal.live.messages import GREATEST, LONGEST, ROBOT, Command, Message, NotUnderstood, Ping, Plan, Watch

GOOD = [
    ({"t": "command", "kind": "up", "args": {}, "seq": 1}, Command("up", 1)),
    ({"t": "command", "kind": "move", "args": {"x": 0.25, "y": 1}, "seq": GREATEST}, Command("move", GREATEST, {"x": 0.25, "y": 1})),
    ({"t": "ping", "n": 7}, Ping(7)),
    ({"t": "watch", "cameras": [0, 2]}, Watch([0, 2])),
    ({"t": "watch", "cameras": [], "sound": True}, Watch([], sound=True)),
    ({"t": "plan", "n": 3, "kind": "line", "args": {"x": None}, "from": [0, 0.5]}, Plan("line", [0.0, 0.5], {"x": None}, 3)),
]  # fmt: skip
WRONG = [  # understood as JSON objects, answered with a sentence
    {"t": "command", "kind": [], "seq": 1}, {"t": "command", "kind": "", "seq": 1}, {"t": "command", "kind": "x" * 31, "seq": 1},
    {"t": "command", "kind": "up", "seq": 0}, {"t": "command", "kind": "up", "seq": 2**53}, {"t": "command", "kind": "up", "seq": True},
    {"t": "command", "kind": "up", "seq": 1.5}, {"t": "command", "kind": "up"}, {"t": "command", "kind": "u\0", "seq": 1},
    {"t": "command", "kind": "up", "seq": 1, "args": []}, {"t": "command", "kind": "up", "seq": 1, "args": {"x": [1]}},
    {"t": "command", "kind": "up", "seq": 1, "args": {"x": 10**400}}, {"t": "command", "kind": "up", "seq": 1, "args": {"x": "\0"}},
    {"t": "command", "kind": "up", "seq": 1, "args": {str(i): 0 for i in range(33)}}, {"t": "command", "kind": "up", "seq": 1, "more": 1},
    {"t": "stop", "sent": True}, {"t": "keep", "seq": "1"}, {"t": "watch", "cameras": [8]}, {"t": "watch", "cameras": [0], "sound": 1},
    {"t": "watch", "cameras": [-1]},
    {"t": "watch", "cameras": [0] * 9}, {"t": "plan", "kind": "line", "from": [0.0] * 17}, {"t": "plan", "kind": "line", "from": "x"},
    {"t": "trace", "on": 1}, {"t": "release", "checked": "yes"}, {"t": "nope"}, {"t": None}, {"t": []}, {},
]  # fmt: skip
HOPELESS = [
    None,
    "",
    "{",
    "[]",
    "1",
    '"x"',
    "null",
    "\ud800",
    '{"t":"ping","n":NaN}',
    "{}" + " " * LONGEST,
    "[" * 4000,
    '{"a":' + "[" * 4000,
]


@pytest.mark.parametrize(("said", "meant"), GOOD)
def test_what_the_pages_send_is_understood(said, meant):
    assert ROBOT.decode(json.dumps(said)) == meant


@pytest.mark.asvs("1.4.2", "15.3.5")
@pytest.mark.parametrize("said", WRONG)
def test_what_is_out_of_bounds_is_answered_in_words(said):
    with pytest.raises(NotUnderstood, match="reload the page") as refused:
        ROBOT.decode(json.dumps(said))
    assert not refused.value.hopeless
    assert refused.value.to == (
        said.get("t") or ""
        if isinstance(said.get("t", ""), str)
        and isinstance(said.get("seq", 0), int)
        and 0 <= said.get("seq", 0) < 2**53
        and not isinstance(said.get("seq"), bool)
        else ""
    )


@pytest.mark.parametrize("text", HOPELESS)
def test_what_no_page_sends_closes_the_socket(text):
    with pytest.raises(NotUnderstood) as refused:
        ROBOT.decode(text)
    assert refused.value.hopeless


def test_a_refused_command_keeps_its_number_so_that_the_page_can_show_the_refusal():
    with pytest.raises(NotUnderstood) as refused:
        ROBOT.decode('{"t": "command", "kind": "up", "seq": 41, "args": {"x": {}}}')
    assert (refused.value.to, refused.value.seq) == ("command", 41)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=40),
    lambda inner: st.lists(inner, max_size=6) | st.dictionaries(st.text(max_size=12), inner, max_size=6),
    max_leaves=30,
)
FIELDS = st.sampled_from(["t", "kind", "seq", "args", "n", "from", "cameras", "on", "checked"])
KINDS = st.sampled_from([t.__struct_config__.tag for t in Message.__subclasses__()])


@settings(max_examples=40)
@given(st.dictionaries(FIELDS, JSON, max_size=6), st.none() | KINDS)
def test_any_object_is_a_message_or_a_refusal(fields, kind):
    text = json.dumps(fields | ({"t": kind} if kind else {}))
    try:
        message = ROBOT.decode(text)
    except NotUnderstood:
        return
    assert isinstance(message, Message)
    assert len(msgspec.json.encode(message)) < 4 * LONGEST


@given(st.text(max_size=200) | st.binary(max_size=200).map(lambda b: b.decode("latin-1")))
def test_any_text_is_a_message_or_a_refusal(text):
    with contextlib.suppress(NotUnderstood):
        ROBOT.decode(text)


@pytest.mark.timed
def test_the_largest_messages_cost_little(stopwatch):
    worst = [
        '{"t":"plan","kind":"x","from":[],"args":{"x":"' + "a" * 8000 + '"}}',
        "[" * LONGEST,
        '{"a":' * 1300,
        '{"t":"ping","n":' + "9" * 8000 + "}",
    ]
    begun = stopwatch.process_time()
    for text in worst * 10:
        with contextlib.suppress(NotUnderstood):
            ROBOT.decode(text)
    assert stopwatch.process_time() - begun < 0.4  # 10 ms a message, many times what it takes
