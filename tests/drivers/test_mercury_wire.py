"""The Mercury simulator by raw bytes, as its README describes them."""

import json
import math
import os
import time
from pathlib import Path

import pytest

from tests.conftest import wait_for
from tests.drivers.mercury_wire import (
    ACK,
    AIR,
    BURY,
    CALIBRATE,
    CHECKSUM,
    DONE,
    HELD,
    HOLD,
    LENGTH,
    MOVE_THETA,
    MOVE_XYZ,
    NAK,
    RANGE,
    RESET,
    SPEED,
    STALE,
    STATE,
    STATUS,
    UNKNOWN,
    Terminal,
    floats,
    frame,
)

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

WILD = (math.nan, math.inf, -math.inf, 1e30, -1e30, 3.4e38, 1e308)


@pytest.fixture
def line(sim):
    terminal = Terminal(sim.folder / "tty")
    yield terminal
    terminal.close()


def test_no_number_is_believed_that_cannot_be_meant(line, sim):
    seq = line.calibrated(1)
    for value in WILD:
        asked = [(MOVE_THETA, (value,)), (AIR, (value,)), (SPEED, (value,)), (BURY, (value,))]
        asked += [(MOVE_XYZ, tuple(value if i == k else v for k, v in enumerate((0.0, 420.0, 75.0)))) for i in range(3)]
        for instruction, values in asked:
            assert line.ask(instruction, seq, floats(*values)) == (NAK, RANGE)
            seq += 1
    assert (sim.count("motion"), sim.count("burst")) == (0, 0)
    assert not sim.status()["moving"]


def test_a_bed_has_a_whole_number_and_is_made_beside_a_motion(line, sim):
    seq = line.calibrated(1)
    for number in (0.0, -1.0, 0.5, 2.5, 2.0**24):
        assert line.ask(BURY, seq, floats(number)) == (NAK, RANGE)
        seq += 1
    assert sim.count("bury") == 0
    assert line.ask(MOVE_XYZ, seq, floats(100.0, 420.0, 75.0))[0] == ACK
    assert line.ask(BURY, seq + 1, floats(2.0))[0] == ACK
    assert json.loads((sim.folder / "pieces.json").read_text())["number"] == 2
    assert line.ended(seq, 20.0)[0] == DONE
    wait_for((sim.folder / "bed.npy").exists, 60, "the new bed")
    assert sim.count("bury") == 1


def test_the_tool_turns_inside_the_limits_of_its_joint(line, sim):
    begin = line.calibrated(1)
    assert line.ask(SPEED, begin, floats(600.0))[0] == ACK
    for seq, degrees in enumerate((100.0, -170.0, 350.0, 0.0), begin + 1):
        assert line.ask(MOVE_THETA, seq, floats(degrees))[0] == ACK
        assert line.ended(seq, 20.0)[0] == DONE
        assert math.remainder(math.degrees(sim.status()["pose"][3]) - degrees, 360) == pytest.approx(0, abs=0.01)
    assert sim.count("passed") == 0


def test_nak_1_a_checksum_that_does_not_fit(line):
    spoilt = bytearray(frame(STATUS, 7))
    spoilt[-1] ^= 0x55
    line.write(bytes(spoilt))
    assert line.until(lambda heard: [(h[0], h[1], h[2][-1]) for h in heard]) == [(NAK, 7, CHECKSUM)]
    assert line.ask(STATUS, 7)[0] == STATE


def test_a_number_refused_for_its_checksum_is_still_free(line, sim):
    spoilt = bytearray(frame(RESET, 1))
    spoilt[3] ^= 1
    line.write(bytes(spoilt))
    assert line.until(lambda heard: [(h[0], h[1], h[2][-1]) for h in heard]) == [(NAK, 1, CHECKSUM)]
    assert line.ask(RESET, 1)[0] == ACK
    assert sim.count("power_on") == 1


def test_nak_2_an_instruction_that_is_not_known(line):
    for seq, unknown in enumerate((0x00, 0x03, 0x17, 0x81, 0xFF), 1):
        assert line.ask(unknown, 2 * seq) == (NAK, UNKNOWN)
        assert line.ask(unknown, 2 * seq + 1, floats(1.0)) == (NAK, UNKNOWN)


def test_nak_3_a_length_that_does_not_fit_the_instruction(line, sim):
    boot, seq = sim.status()["boot"], 0
    for instruction in (MOVE_XYZ, MOVE_THETA, AIR, RESET, CALIBRATE, STATUS, SPEED, HOLD, BURY):
        for data in (b"\0", b"\0" * 5, b"\0" * 47):
            seq += 1
            assert line.ask(instruction, seq, data) == (NAK, LENGTH)
    assert sim.status()["boot"] == boot
    assert sim.count("calibrate") == sim.count("hold") == 0


def test_a_hold_is_heard_behind_rubbish_half_a_frame_and_under_an_old_number(line, sim):
    seq = line.calibrated(1)
    assert line.ask(SPEED, seq, floats(40.0))[0] == ACK
    assert line.ask(MOVE_XYZ, 100, floats(200.0, 500.0, 75.0))[0] == ACK
    line.heard.clear()
    line.write(b"\x01\x2f\xff\x13" + frame(MOVE_XYZ, 101, floats(1.0, 2.0, 3.0))[:9] + frame(HOLD, 50))
    assert line.until(lambda heard: (HELD, 100) in [h[:2] for h in heard])
    assert (ACK, 50) in [h[:2] for h in line.heard]
    assert line.ask(MOVE_XYZ, 60, floats(0.0, 420.0, 75.0)) == (NAK, STALE), "nothing else is done under an old number"
    assert not sim.status()["moving"]


def held_in_mid_burst(line, sim, seq):
    """Blow for 0.5 s and send a hold after 0.1 s of the line; return the journal's notes of begin, hold and end."""
    line.heard.clear()
    line.write(frame(AIR, seq, floats(0.5)) + b"\xff" * 48 + frame(HOLD, seq + 1))
    assert line.until(lambda heard: {(ACK, seq), (ACK, seq + 1)} <= {h[:2] for h in heard})
    assert line.until(lambda heard: any(h[1] == seq and h[0] in (DONE, HELD) for h in heard))
    return (next(r for r in reversed(sim.journal()) if r["event"] == e) for e in ("burst", "hold", "burst_end"))


def test_a_hold_ends_an_air_burst(line, sim):
    seq = line.calibrated(1)
    assert line.ask(MOVE_XYZ, seq, floats(0.0, 420.0, 0.0))[0] == ACK
    assert line.ended(seq)[0] == DONE
    for _ in range(20):  # on a machine that stalls meanwhile the hold is heard after the burst
        seq += 2
        begun, held, ended = held_in_mid_burst(line, sim, seq)
        if (held["t"] - begun["t"]) * sim.speed < 0.5 and ended["t"] - held["t"] < 0.01:
            break
    assert (ended["why"], ended["seq"]) == ("held", begun["seq"])
    assert (HELD, seq) in {h[:2] for h in line.heard}
    assert ended["t"] - held["t"] < 0.01, "the valve shuts at the hold"
    assert ended["seconds"] == pytest.approx((ended["t"] - begun["t"]) * sim.speed, abs=0.01 * sim.speed)
    assert ended["seconds"] < 0.5
    assert line.ask(AIR, seq + 2, floats(0.05))[0] == ACK
    assert line.ended(seq + 2)[0] == DONE
    whole = [r for r in sim.journal() if r["event"] == "burst_end"][-1]
    assert (whole["why"], whole["seconds"]) == ("done", pytest.approx(0.05, abs=0.002))


def kill(sim):
    sim.process.kill()
    sim.process.wait()


def test_it_stands_where_it_was_killed(line, sim):
    seq = line.calibrated(1)
    begun = sim.status()["pose"][0]
    line.ask(SPEED, seq, floats(25.0))
    line.ask(MOVE_XYZ, seq + 1, floats(200.0, 420.0, 75.0))
    wait_for(lambda: sim.status()["pose"][0] > 0.02, 6, "it is on its way")
    kill(sim)
    kept = json.loads((sim.folder / "state.json").read_text())["pose"]
    sim.start()
    pose = sim.status()["pose"]
    assert pose == pytest.approx(kept)
    assert begun + 0.01 < pose[0] < 0.19, "neither where the motion began nor where it was to end"


def test_a_boot_number_never_comes_twice(sim):
    numbers = [sim.status()["boot"]]
    for _ in range(3):
        sim.fault("power_cycle", count=1)
        numbers.append(wait_for(lambda: (b := sim.status()["boot"]) not in numbers and b, 5, "power lost"))
        kill(sim)  # right behind it, before anything rests
        sim.start()
        numbers.append(sim.status()["boot"])
    assert len(set(numbers)) == len(numbers), numbers
    assert max(numbers) > 255 or numbers == sorted(numbers)
    sim.stop()
    state = sim.folder / "state.json"
    state.write_text(json.dumps({"pose": [0, 0.42, 0.075, 0], "boot": 255}))
    sim.start()
    assert sim.status()["boot"] == 256, "it does not begin again at one"


@pytest.mark.asvs("1.3.3", "1.4.2")
def test_a_flood_waits_in_the_senders_buffer(line, sim):
    """The line takes no more than it can carry, so nobody fills the controller's memory."""
    os.set_blocking(line.descriptor, False)
    pid, sent = sim.process.pid, 0

    def memory():
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    before = memory()
    until = time.monotonic() + 2 / sim.speed
    while time.monotonic() < until:
        try:
            sent += os.write(line.descriptor, b"\xaa" * 65536)
        except BlockingIOError:
            time.sleep(0.01)
    assert sent < 200_000
    assert memory() - before < 4_000_000


@pytest.mark.parametrize("cut", range(1, 8))
def test_a_line_taken_over_in_the_middle_of_a_message_is_read_on_from_the_next_one(cut):
    """A program that was killed has read a part of a message; whoever opens the line then hears the rest."""
    simulator, program = os.openpty()
    try:
        torn, whole = frame(STATE, 4, bytes(9)), frame(ACK, 5, b"\0")
        terminal = Terminal(Path(os.ttyname(program)))
        os.write(simulator, torn[cut:] + whole)
        assert terminal.until(lambda heard: (ACK, 5, b"\0") in heard)
        terminal.close()
    finally:
        os.close(simulator)
        os.close(program)
