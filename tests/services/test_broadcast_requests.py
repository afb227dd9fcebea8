"""Requests and answers of a broadcast over HTTP: what an origin in trouble may answer, and what anybody may ask."""

import asyncio

import pytest

from portal.broadcast import repairs
from portal.broadcast.answers import LONGEST_PATH, Answer, application
from portal.broadcast.assembly import Gap
from portal.broadcast.edge import LONGEST

GAP = Gap(3, 100, 200, 0)
GOOD = b"HTTP/1.1 206 Partial Content\r\nContent-Length: 4\r\nFarhand-Tag: 00\r\n\r\nabcd"


async def answer_of(said, close=True):
    """Return what is made of an answer, and what was asked."""
    asked, writers = [], []

    async def serve(reader, writer):
        writers.append(writer)
        asked.append(await reader.readuntil(b"\r\n\r\n"))
        writer.write(said)
        if close:
            writer.close()
        else:
            await reader.read()  # until the other side hangs up

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    try:
        return await repairs.fetch(f"http://127.0.0.1:{port}/far", 7, GAP), asked[0].decode()
    finally:
        server.close()
        for writer in writers:
            writer.transport.abort()
        await asyncio.sleep(0.01)  # an aborted connection is closed in the next turn of the loop


def test_a_gap_is_asked_for_by_its_range():
    answer, asked = asyncio.run(answer_of(GOOD))
    assert asked.startswith("GET /far/00000007/3 HTTP/1.1\r\n")
    assert "\r\nRange: bytes=100-199\r\n" in asked
    assert (answer.status, answer.body, answer.headers["farhand-tag"]) == (206, b"abcd", "00")


@pytest.mark.parametrize(
    "said",
    [
        b"", b"abc", b"\r\n\r\n", GOOD[:-1], GOOD[:40], b"HTTP/1.1 206 OK\r\n\r\nabcd", b"HTTP/2 206\r\nContent-Length: 1\r\n\r\nx",
        GOOD.replace(b": 4", b": -4"), GOOD[:-4].replace(b": 4", b": %d" % (LONGEST + 1)) + b"x" * (LONGEST + 1), GOOD.replace(b": 4", b": " + b"9" * 500),
        GOOD.replace(b"00", b"x" * 20_000), b"x" * 100_000, GOOD.replace(b"Farhand", b"\xff\xfe"[:1] * 20_000),
        b"HTTP/1.1 206 OK\r\n" + b"a: b\r\n" * 500 + b"Content-Length: 1\r\n\r\nx",
    ],
    ids=lambda said: said[:40],
)  # fmt: skip
def test_an_answer_that_is_none_is_none(said):
    assert asyncio.run(answer_of(said))[0] is None


def test_an_origin_that_says_nothing_is_waited_for_so_long_and_no_longer(monkeypatch):
    monkeypatch.setattr(repairs, "TIMEOUT_S", 0.2)
    assert asyncio.run(answer_of(b"HTTP/1.1 206 OK\r\nContent-Le", close=False))[0] is None
    assert asyncio.run(answer_of(GOOD[:-1], close=False))[0] is None


@pytest.mark.parametrize(
    "origin", ["http://127.0.0.1:1", "http://[::1", "http://nowhere.invalid:80", "http://", "http://x:99999"]
)
def test_an_origin_that_is_not_there_is_no_answer(origin):
    assert asyncio.run(repairs.fetch(origin, 7, GAP)) is None


def asked(method="GET", path="/x", kind="http"):
    """Return what an application sends."""
    sent = []

    async def send(message):
        sent.append(message)

    async def receive():
        raise AssertionError("no body is read")

    made = application(lambda place, headers: Answer(200, f"{place} {headers}".encode(), {"cache-control": "no-store"}))
    scope = {"type": kind, "method": method, "path": path, "headers": [(b"range", b"bytes=\xff")]}
    asyncio.run(made(scope, receive, send))
    return sent


def test_get_has_a_body_and_head_has_none():
    start, body = asked()
    assert dict(start["headers"])[b"content-length"] == str(len(body["body"])).encode() != b"0"
    assert dict(start["headers"])[b"cache-control"] == b"no-store"
    head_start, head = asked("HEAD")
    assert head["body"] == b""
    assert head_start == start


def test_other_methods_and_long_addresses_are_refused_before_anything_is_looked_up():
    assert asked("POST")[0]["status"] == 405
    assert asked(path="/" + "x" * LONGEST_PATH)[0]["status"] == 404
    assert asked(kind="websocket") == [{"type": "websocket.close"}]
