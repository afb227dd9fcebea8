"""Attacks on the real web process: its log of them is short, in lines of its own, and no request waits for it."""

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys

import pytest

from portal.logs.lines import MESSAGE, TRACE
from portal.logs.outlet import ROOM
from portal.run.processes import web_process
from tests.conftest import at_length, wait_for
from tests.rig import ROOT, Web, child_env, free_port
from tests.waiting import CEILING_S

pytestmark = pytest.mark.django_db(transaction=True)
EVIL = "a\r\n2027-01-15T08:00:00.250Z ERROR root: forged\x1b[2J\x9b\u2028\u202e".encode()
QUOTED = "".join(f"%{byte:02x}" for byte in EVIL).encode()
PLAIN = EVIL.replace(b"\r\n", b"\r")
BEGUN = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z [A-Z]+ [\w.]+: ")
UPGRADE = b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"


def get(path, host=b"localhost", more=b"Connection: close\r\n"):
    return b"GET " + path + b" HTTP/1.1\r\nHost: " + host + b"\r\n" + more + b"\r\n"


ATTACKS = {
    "a long address": get(b"/" + b"a" * 60_000),
    "an address with control characters": get(b"/" + QUOTED * 100),
    "an address with raw bytes": get(b"/" + PLAIN * 10),
    "a foreign host": get(b"/", host=b"evil.example"),
    "a long host": get(b"/", host=b"e" * 60_000),
    "a host with raw bytes": get(b"/", host=b"e\x1b[2J\x9b\xe2\x80\xae" * 100),
    "two hosts": get(b"/", more=b"Host: evil.example\r\n"),
    "a strange method": b"BREW" * 1000 + b" / HTTP/1.1\r\nHost: localhost\r\n\r\n",
    "no request": PLAIN * 1000 + b"\r\n\r\n",
    "a wrong header": get(b"/", more=b"X-A\x1b: " + PLAIN + b"\r\n"),
    "a long cookie": get(b"/", more=b"Cookie: sessionid=" + b"c" * 50_000 + b"\r\n"),
    "a length without end": get(b"/", more=b"Content-Length: " + b"9" * 1000 + b"\r\n"),
    "a wrong chunk": b"POST /accounts/login/ HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n\x1b[2J\r\n",
    "a form that is no form": b"POST /accounts/login/ HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
    b"Content-Type: multipart/form-data; boundary="
    + PLAIN.replace(b"\r", b"")
    + b"\r\nContent-Length: 9\r\n\r\n"
    + b"\x1b" * 9,
    "a number without end": get(b"/log/?created_at__year=" + b"9" * 5000),
    "a socket of another site": get(
        b"/ws/robots/mercury/", more=b"Origin: http://" + b"e" * 30_000 + b"\r\n" + UPGRADE
    ),
    "a socket nowhere": get(b"/ws/" + QUOTED * 50, more=UPGRADE),
    "a socket with a wrong key": get(b"/ws/me/", more=UPGRADE.replace(b"dGhl", PLAIN)),
}


def send(port, attack):
    """Send an attack; read what comes until the other end has closed."""
    with socket.create_connection(("127.0.0.1", port), timeout=CEILING_S) as line, contextlib.suppress(ConnectionError):
        line.sendall(attack)
        while line.recv(65536):
            pass


def answers(port):
    with socket.create_connection(("127.0.0.1", port), timeout=CEILING_S) as line:
        line.sendall(get(b"/livez"))
        return line.recv(65536).startswith(b"HTTP/1.1 200 ")


def records(log):
    """Divide a log into records: a line, and those of its traceback."""
    found = []
    for line in log.splitlines(keepends=True):
        if BEGUN.match(line) or not found:
            found.append("")
        found[-1] += line
    return found


@pytest.mark.asvs("16.4.1")
def test_a_request_writes_little_into_the_log_and_nothing_of_its_own_form(transactional_db, redis_server, robot):
    web = Web(LOG_LEVEL="DEBUG", FARHAND_HEAD_S="1", FARHAND_BODY_S="1")
    try:
        for what, attack in ATTACKS.items():
            wait_for(lambda: answers(web.port), CEILING_S, f"an answer after {what}")
            send(web.port, attack)
        assert answers(web.port)
    finally:
        assert web.stop() == 0
    log = web.log.read_bytes().decode()  # strictly
    assert all(line.isprintable() for line in log.split("\n"))
    said = records(log)
    assert all(len(record.encode()) <= MESSAGE + TRACE + 400 for record in said), max(said, key=len)
    assert not [line for line in log.splitlines() if line.startswith("2027-")], "forged"
    loud = [record for record in said if " DEBUG " not in record.splitlines()[0]]
    assert len(loud) <= 2 * len(ATTACKS), "a request or two lines each"
    assert all(BEGUN.match(record) for record in loud)


@pytest.mark.asvs("15.2.2")
@pytest.mark.parametrize("reads", ["nobody", at_length("nobody any more")])
def test_a_full_log_delays_no_request(transactional_db, redis_server, robot, reads):
    """More is logged than the pipe and the queue before it hold together."""
    ours, theirs = os.pipe()
    port = free_port()
    spec = web_process("127.0.0.1", port)
    env = child_env(**spec.env)
    web = subprocess.Popen(spec.argv, cwd=ROOT, env=env, stdout=theirs, stderr=theirs, start_new_session=True)
    os.close(theirs)
    try:
        if reads == "nobody any more":
            os.close(ours)

        def begun():
            assert web.poll() is None
            with contextlib.suppress(OSError):
                return answers(port)

        wait_for(begun, CEILING_S, "the web process")
        for _ in range(2 * (ROOM + 65_536) // MESSAGE):
            send(port, get(b"/", host=b"e" * 1000))
        assert answers(port)
        web.send_signal(signal.SIGTERM)
        assert web.wait(CEILING_S) == 0
    finally:
        web.kill()
        web.wait()
        if reads == "nobody":
            os.close(ours)


FULL = """
import os, sys
ours, theirs = os.pipe()
os.set_inheritable(ours, True)
os.set_blocking(theirs, False)
try:
    while True:
        os.write(theirs, b"x" * 4096)
except BlockingIOError:
    os.set_blocking(theirs, True)
os.dup2(theirs, 1)
os.dup2(theirs, 2)
os.execv(sys.argv[1], sys.argv[1:])
"""


@pytest.mark.asvs("15.2.2")
def test_a_full_log_delays_no_robot(rig):
    """Not a byte of what its owner says finds room, from the beginning on."""
    owner = rig.start_worker(before=(sys.executable, "-c", FULL), LOG_LEVEL="DEBUG")
    rig.wait_ready()
    rig.grant()
    command = rig.final(rig.issue("down"))
    assert command.state == "completed", command.reason
    assert owner.stop() == 0
    assert not owner.said()
