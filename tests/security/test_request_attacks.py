"""Requests that never end, or never end asking, over raw connections to the portal's HTTP protocol.

Judged by the bytes and requests that it takes, by what it answers, and by the connections that it ends.
"""

import asyncio
import contextlib
import socket
import struct

import pytest
import uvicorn
from hypothesis import given
from hypothesis import settings as effort
from hypothesis import strategies as st
from uvicorn.server import ServerState

from portal.edge import protocols
from portal.edge.protocols import CHUNKS, FIELDS, HEAD, PIPELINED, Http
from portal.edge.sockets import Ws

CEILING_S = 120
ENDLESS = 64 * 2**20  # bytes; whoever takes so many has no limit
AHEAD = 512 * 1024  # bytes that the two kernels hold at most
GET = b"GET /page HTTP/1.1\r\nHost: localhost\r\n\r\n"
CHUNKED = b"POST /body HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
LONG = b"POST /refused HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n" % ENDLESS
UPGRADE = (
    b"GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


class App:
    """An application that reads each body, answers with it, and waits for `free` first."""

    def __init__(self):
        self.requests, self.parts, self.largest = [], 0, 0
        self.free = asyncio.Event()
        self.free.set()

    async def __call__(self, scope, receive, send):
        assert scope["type"] == "http", "a socket was opened"
        self.requests.append(scope["path"])
        await self.free.wait()
        body, more = b"", scope["path"] != "/refused"
        while more:
            part = await receive()
            if part["type"] == "http.disconnect":
                return
            self.parts += 1
            self.largest = max(self.largest, len(part["body"]))
            body, more = body + part["body"], part["more_body"]
        if scope["path"] == "/large":
            body = bytes(2**20)
        status = 413 if scope["path"] == "/refused" else 200
        headers = [(b"content-length", str(len(body)).encode())]
        await send({"type": "http.response.start", "status": status, "headers": headers})
        await send({"type": "http.response.body", "body": body})


@contextlib.asynccontextmanager
async def served():
    """Serve an application; yield it and a function that connects to it."""
    app, opened = App(), []
    config = uvicorn.Config(
        app, http=Http, ws=Ws, lifespan="off", access_log=False, log_config=None, interface="asgi3",
        timeout_keep_alive=CEILING_S,
    )  # fmt: skip
    config.load()
    state = ServerState()
    server = await asyncio.get_running_loop().create_server(lambda: Http(config, state, {}), "127.0.0.1", 0)

    async def connect():
        line = socket.socket()
        line.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 16 * 1024)
        line.connect(connect.address)
        reader, writer = await asyncio.open_connection(sock=line)
        writer.transport.set_write_buffer_limits(high=0)
        opened.append(writer)
        return reader, writer

    connect.address = server.sockets[0].getsockname()
    try:
        yield app, connect
    finally:
        app.free.set()
        for writer in opened:
            writer.transport.abort()
        for connection in list(state.connections):
            connection.transport.abort()
        server.close()
        await asyncio.gather(*state.tasks, return_exceptions=True)


def attack(how):
    """Run an attack in an event loop; return what it returns."""

    async def run():
        async with asyncio.timeout(CEILING_S), served() as (app, connect):
            return await how(app, connect)

    return asyncio.run(run())


async def pour(writer, data):
    """Send the data again and again until the connection ends; return the number of bytes sent."""
    sent = 0
    with contextlib.suppress(OSError):
        while sent < ENDLESS:
            writer.write(data)
            await writer.drain()
            sent += len(data)
    return sent


async def all_of(reader):
    """Return what arrives until the connection ends, also by a reset."""
    said = b""
    with contextlib.suppress(OSError):
        while part := await reader.read(65536):
            said += part
    return said


def statuses(said):
    """Return the statuses of answers that have no body."""
    return [int(head.split()[1]) for head in said.split(b"\r\n\r\n") if head.startswith(b"HTTP/1.1 ")]


async def endless(app, connect, head, piece):
    reader, writer = await connect()
    writer.write(head)
    said = asyncio.create_task(all_of(reader))  # an answer that is not read may be lost when the connection is reset
    return await pour(writer, piece), await said


@pytest.mark.asvs("15.2.2")
@pytest.mark.parametrize(
    ("head", "piece", "status"),
    [
        pytest.param(CHUNKED + b"0\r\n", b"X-A: " + b"b" * 1000 + b"\r\n", 431, id="trailers"),
        pytest.param(CHUNKED + b"0\r\n", b"a:b\r\n" * 200, 431, id="many short trailers"),
        pytest.param(CHUNKED + b"0\r\nX-A: ", b"b" * 1000, 431, id="one trailer"),
        pytest.param(CHUNKED + b"1;a=", b"b" * 1000, 431, id="a chunk's extension"),
        pytest.param(CHUNKED, b"1\r\nx\r\n" * 100, 400, id="chunks of one byte"),
        pytest.param(CHUNKED, (b"1;" + b"e" * 400 + b"\r\nx\r\n") * 10, 431, id="small chunks with extensions"),
        pytest.param(CHUNKED, b"0" * 1000, 431, id="a chunk's size"),
        pytest.param(b"GET /page HTTP/1.1\r\n", b"X-A: " + b"b" * 1000 + b"\r\n", 431, id="headers"),
        pytest.param(b"GET /page HTTP/1.1\r\n", b"a:b\r\n" * 200, 431, id="many short headers"),
        pytest.param(b"GET /", b"a" * 1000, 431, id="a request line"),
        pytest.param(b"", b"\r\n" * 500, 431, id="empty lines"),
    ],
)
def test_what_is_no_body_is_bounded_wherever_it_stands(head, piece, status):
    async def how(app, connect):
        sent, said = await endless(app, connect, head, piece)
        return sent, said, app.parts

    sent, said, parts = attack(how)
    assert sent < HEAD + AHEAD
    assert statuses(said) in ([status], [])  # nothing, where the reset overtakes the answer
    assert parts <= CHUNKS


@pytest.mark.asvs("15.2.2")
def test_the_rest_of_a_refused_body_is_not_read():
    async def how(app, connect):
        reader, writer = await connect()
        writer.write(LONG)
        head = await reader.readuntil(b"\r\n\r\n")
        return head, await pour(writer, bytes(65536)), app.requests

    head, sent, requests = attack(how)
    assert statuses(head) == [413]
    assert sent < 2 * AHEAD + 65536
    assert requests == ["/refused"]


def test_a_hundred_headers_are_taken_and_one_more_is_not():
    async def how(app, connect):
        reader, writer = await connect()
        heads = []
        for more in (FIELDS - 1, FIELDS):
            writer.write(b"GET /page HTTP/1.1\r\nHost: localhost\r\n" + b"A: b\r\n" * more + b"\r\n")
            heads.append(await reader.readuntil(b"\r\n\r\n"))
        return b"".join(heads), app.requests

    said, requests = attack(how)
    assert statuses(said) == [200, 431]
    assert requests == ["/page"]


@pytest.mark.asvs("15.2.2")
def test_of_requests_that_nobody_waits_for_few_are_taken():
    async def how(app, connect):
        app.free.clear()
        reader, writer = await connect()
        writer.write(GET * PIPELINED)
        while not app.requests:
            await asyncio.sleep(0)
        app.free.set()
        answers = [await reader.readuntil(b"\r\n\r\n") for _ in range(PIPELINED)]
        app.free.clear()
        sent, said = await endless(app, connect, b"", GET * 100)
        return b"".join(answers), sent, said, app.requests

    answers, sent, said, requests = attack(how)
    assert statuses(answers) == [200] * PIPELINED
    assert sent < AHEAD
    assert statuses(said) in ([429], [])
    assert len(requests) <= PIPELINED + 1


@pytest.mark.asvs("15.2.2")
def test_who_never_reads_is_not_served_for_ever():
    async def how(app, connect):
        reader, writer = await connect()
        reader._transport.pause_reading()
        sent = await pour(writer, GET.replace(b"/page", b"/large") * 100)
        return sent, app.requests

    sent, requests = attack(how)
    assert sent < AHEAD
    assert len(requests) <= PIPELINED + 1


@pytest.mark.asvs("15.2.2")
def test_a_socket_is_not_opened_in_the_middle_of_other_answers():
    async def how(app, connect):
        app.free.clear()
        reader, writer = await connect()
        writer.write(GET + UPGRADE)
        return await all_of(reader)

    assert statuses(attack(how)) == [400]


def test_what_follows_an_unknown_upgrade_is_no_request():
    async def how(app, connect):
        reader, writer = await connect()
        writer.write(GET.replace(b"\r\n\r\n", b"\r\nUpgrade: h2c\r\nConnection: Upgrade\r\n\r\n") + GET * 3)
        return await all_of(reader), app.requests

    said, requests = attack(how)
    assert statuses(said) == [200]
    assert requests == ["/page"]


def test_after_a_refusal_nothing_is_read(monkeypatch):
    refused = []
    monkeypatch.setattr(protocols, "drop", refused.append)

    async def how(app, connect):
        reader, writer = await connect()
        writer.write(b"\x16\x03\x01 nonsense\r\n\r\n" + GET * 3)
        first = await all_of(reader)
        writer.write(GET)
        return first, app.requests

    said, requests = attack(how)
    assert statuses(said) == [400]
    assert requests == []
    assert refused == ["sent no HTTP"]


@pytest.mark.asvs("15.2.2")
def test_a_connection_that_was_reset_before_it_is_accepted_is_no_request(caplog):
    async def how(app, connect):
        for _ in range(20):
            with socket.socket() as line:
                line.connect(connect.address)
                line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                line.sendall(GET)
        reader, writer = await connect()
        writer.write(GET)
        return statuses(await reader.readuntil(b"\r\n\r\n")), app.requests

    answered, requests = attack(how)
    assert answered == [200]
    assert requests == ["/page"]
    assert not caplog.records


bodies = st.lists(st.binary(max_size=300), max_size=5)


def request(parts, chunked, trailer):
    if not chunked:
        body = b"".join(parts)
        return b"POST /body HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n%s" % (len(body), body)
    chunks = b"".join(b"%x\r\n%s\r\n" % (len(part), part) for part in parts if part)
    return CHUNKED + chunks + b"0\r\n" + (b"X-Sum: 7\r\n" if trailer else b"") + b"\r\n"


@effort(max_examples=30, deadline=None)
@given(st.lists(st.tuples(bodies, st.booleans(), st.booleans()), min_size=1, max_size=30), st.integers(1, 400))
def test_honest_requests_are_answered_however_many_follow_and_however_they_are_cut(requests, size):
    async def how(app, connect):
        reader, writer = await connect()
        said = []
        for parts, chunked, trailer in requests:
            data = request(parts, chunked, trailer)
            for start in range(0, len(data), size):
                writer.write(data[start : start + size])
                await writer.drain()
            head = await reader.readuntil(b"\r\n\r\n")
            length = int(head.lower().partition(b"content-length: ")[2].split()[0])
            said.append(await reader.readexactly(length))
        return said

    assert attack(how) == [b"".join(parts) for parts, *_ in requests]
