"""Texts over a thin line are compressed against those before; every client that keeps its window reads them."""

import json

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from websockets.extensions.permessage_deflate import ClientPerMessageDeflateFactory
from websockets.frames import Frame, Opcode

from portal.edge.compression import DEFLATE, HISTORY, SETTINGS, Deflate, suits, text_frames
from tests.unit.test_writer import parsed

TEXTS = st.one_of(
    st.text(max_size=300), st.sampled_from(["snapshot " * 400, "snapshot " * 399 + "other", "é" * HISTORY])
)


def agreed(**asked):
    """Return both ends of a connection: what a client asks for, answered by the portal."""
    factory = ClientPerMessageDeflateFactory(**{"client_max_window_bits": True, **asked})
    params, ours = DEFLATE.process_request_params(factory.get_request_params(), [])
    return ours, factory.process_response_params(params, [])


def sent(ours, theirs, text):
    """Return a text as the client reads it, and the bytes of its frame."""
    frame = Frame(Opcode.TEXT, text.encode()).serialize(mask=False, extensions=[ours])
    return bytes(parsed(frame, theirs).data).decode(), len(frame)


@given(st.lists(st.tuples(TEXTS, st.sampled_from(["own", "own", "own", "shared", "plain", "on", "off"])), max_size=30))
def test_every_text_is_read_as_it_was_whatever_was_sent_before(steps):
    ours, theirs = agreed()
    for text, how in steps:
        if how in ("on", "off"):
            ours.remember(how == "on")
        elif how == "own" or ours.remembers:
            assert sent(ours, theirs, text)[0] == text
        else:
            frame = text_frames(text)[how == "shared" and suits(ours)]
            assert bytes(parsed(frame, theirs).data).decode() == text


@given(st.lists(TEXTS, max_size=10), st.integers(9, 15), st.booleans())
def test_what_a_client_asks_for_is_kept_to(texts, bits, forgets):
    ours, theirs = agreed(server_max_window_bits=bits, server_no_context_takeover=forgets)
    ours.remember(True)
    assert ours.remembers is not forgets
    for text in texts:
        assert sent(ours, theirs, text)[0] == text


def test_a_snapshot_that_repeats_the_last_one_takes_some_dozen_bytes():
    ours, theirs = agreed()
    ours.remember(True)
    snapshot = {"t": "snapshot", "log": [{"id": n, "text": f"entry {n * 7919}", "at_ms": 17 * n} for n in range(100)]}
    _, first = sent(ours, theirs, json.dumps(snapshot))
    text, second = sent(ours, theirs, json.dumps(snapshot | {"queue": 3}))
    assert json.loads(text)["queue"] == 3
    assert second < first / 8
    assert second < 120
    assert ours.size(json.dumps(snapshot).encode()) < 120, "as is said of one that is not sent"


def test_bytes_that_repeat_a_message_before_are_compressed_and_others_stay_as_they_are():
    ours, theirs = agreed()
    ours.remember(True)
    told = json.dumps({name: {"how": "measured", "at_ms": 1795967136285} for name in "abcde"}).encode()
    noise = bytes(np.random.default_rng(3).integers(0, 256, 200, np.uint8))
    sizes = []
    for data in (told, noise, told.replace(b"285", b"944")):
        assert ours.size(data) <= len(data)
        frame = Frame(Opcode.BINARY, data).serialize(mask=False, extensions=[ours])
        found = parsed(frame, theirs)
        assert (bytes(found.data), found.opcode) == (data, Opcode.BINARY)
        sizes.append(len(frame))
    assert sizes[1] <= len(noise) + 4
    assert sizes[2] < 50


def test_bytes_and_fragments_between_texts_break_nothing():
    ours, theirs = agreed()
    ours.remember(True)
    text = "snapshot " * 30
    assert sent(ours, theirs, text)[0] == text
    frame = Frame(Opcode.BINARY, b"picture" * 40).serialize(mask=False, extensions=[ours])
    assert bytes(parsed(frame, theirs).data) == b"picture" * 40
    assert sent(ours, theirs, text)[0] == text
    ping = Frame(Opcode.PING, b"12").serialize(mask=False, extensions=[ours])
    assert parsed(ping, theirs).data == b"12"
    assert sent(ours, theirs, text)[1] < 20


def test_an_idle_connection_keeps_no_compressor():
    ours, _ = agreed()
    assert isinstance(ours, Deflate)
    assert not hasattr(ours, "encoder")
    assert ours.compress_settings == SETTINGS
    ours.remember(True)
    assert not hasattr(ours, "encoder")
