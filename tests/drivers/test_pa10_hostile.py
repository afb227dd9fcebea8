"""The museum arm's driver against a controller that says anything: each answer is judged, and the next one is read."""

import contextlib
import socket
import threading
import time

import pytest

from robots.kit.contract.errors import RobotError
from robots.kit.drivers.pa10.driver import Driver
from robots.kit.drivers.pa10.line import ANSWER_S, ArmLine
from robots.kit.drivers.pa10.protocol import ArmState, End, Mode

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

STATE = ArmState(Mode.NO_CTRL, 3, End.DONE, 1, 0, 0, 1, 0.02, False, (0.1,) * 6, (0.0,) * 6, (1.0,) * 6, "")
WELL = STATE.encode().encode() + b"\n"


class Controller:
    """Answers each line with `answer(line)`, on one connection after the other."""

    def __init__(self):
        self.answer = self.well
        self._server = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._server.getsockname()[1]}"
        threading.Thread(target=self._listen, daemon=True).start()

    @staticmethod
    def well(line):
        return {b"s": WELL, b"h": b"ok hold\n", b"i": b"ok epoch 1\n", b"b": b"ok 0 boxes\n"}[line[:1]]

    def _listen(self):
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._server.accept()
                with client, client.makefile("rb") as lines, contextlib.suppress(OSError):
                    for line in lines:
                        self._say(client, self.answer(line))

    @staticmethod
    def _say(client, said):
        if isinstance(said, bytes):
            client.sendall(said)
            return
        for piece in said:
            client.sendall(piece)

    def close(self):
        self._server.close()


@pytest.fixture
def controller():
    made = Controller()
    yield made
    made.close()


def changed(field, value):
    parts = STATE.encode().split()
    return " ".join(f"{field}={value}" if p.startswith(f"{field}=") else p for p in parts).encode() + b"\n"


HOSTILE = [
    changed("motion", "9" * 309), changed("boot", "9" * 1900), changed("opening", "nan"), changed("opening", "1e308"),
    changed("q", ",".join(["nan"] * 6)), changed("q", ",".join(["1e308"] * 6)), changed("t", ",".join(["inf"] * 6)),
    b"\n", b"s\n", b"\xff\xfe\xfd\n", b"e\n", b"e range\n", b"ok\n", b"s " + b"9" * 1900 + b"\n",
]  # fmt: skip


@pytest.mark.parametrize("said", HOSTILE)
def test_an_answer_that_cannot_be_meant_is_an_error_in_words_and_the_next_is_read(controller, said):
    driver = Driver(controller.address, {"epoch": 1})
    assert driver.connect().ready
    controller.answer = lambda line: said
    with pytest.raises(RobotError) as refused:
        driver.state()
    assert str(refused.value)
    controller.answer = controller.well
    if not driver.line.is_open:
        driver.line.open()
    assert driver.state().joints == pytest.approx((*[0.1] * 6, 0.02), abs=1e-6)
    driver.close()


def trickle(line):
    while True:
        time.sleep(0.1)
        yield b"s"


@pytest.mark.parametrize("said", [b"s" * 1_000_000, trickle])
def test_an_answer_without_an_end_costs_no_more_than_its_time(controller, said):
    line = ArmLine(controller.address, 1, "", None)
    line.open()
    controller.answer = lambda asked: said(asked) if callable(said) else said
    begun = time.monotonic()
    with pytest.raises(RobotError):
        line.state()
    assert time.monotonic() - begun < 3 * ANSWER_S
    assert not line.is_open
