"""The museum arm's wire as a person at a terminal meets it: judged by the simulator's journal."""

import contextlib
import socket
import struct
import time

import numpy as np
import pytest

from robots.kit.arms.described import chain
from robots.kit.arms.pose import EULER, RPY, numbers
from robots.kit.drivers.pa10.units import pose_request
from tests.conftest import wait_for
from tests.drivers.pa10_wire import Terminal, journal

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


def over(shared, *threads):
    """Wait until threads of the simulator have ended, so that nothing comes of them any more."""
    wait_for(lambda: not {*threads} & {*shared.status()["threads"]}, 10, f"the end of {', '.join(threads)}")


def test_a_velocity_that_is_not_said_again_ends(terminal, shared):
    began = shared.status()["q"][5]
    assert terminal.ask("J 0 0 0 0 0 30") == "ok velocity"
    wait_for(lambda: not shared.status()["moving"], 10, "rest")
    assert 2 < np.degrees(shared.status()["q"][5] - began) < 15, "it went for half a second at most"


def test_a_velocity_that_waited_behind_other_lines_moves_nothing(terminal, shared):
    """A program is checked for longer than a velocity lasts; who has sent both may have let go since."""
    long = [f"l {500 + n % 9} 160 {150 + n} 180 0 180" for n in range(60)]
    assert terminal.ask("\n".join(["u 77", *long, "k 1900 0 100 180 0 180", "."])).startswith("ok program")
    at = time.monotonic()
    terminal.say("p 77", "J 20 0 0 0 0 0", "s")
    assert terminal.hear().startswith("e "), "the program is refused after it was checked"
    said = terminal.hear()
    assert said.startswith("e busy this velocity waited"), said
    assert "moving=0" in terminal.hear()
    assert not journal(shared, "motion", at)


def test_a_velocity_and_its_hold_that_a_stalled_line_delivers_together_move_nothing(terminal, shared):
    at = shared.status()["q"]
    for _ in range(10):
        terminal.say(*["J 60 60 60 60 60 60"] * 20, "h", "W")
        said = [terminal.hear() for _ in range(22)]
        assert {"ok hold", "a"} <= {*said}
    wait_for(lambda: not shared.status()["moving"], 10, "rest")
    assert np.abs(np.subtract(shared.status()["q"], at)).max() < 2e-3


@pytest.mark.parametrize("letter", "kKl")
def test_the_pose_where_the_arm_stands_moves_nothing_at_a_singular_pose(terminal, shared, letter):
    """With W1 at zero E2 and W2 could turn against each other, and the elbow could flip."""
    assert terminal.ask("j 30 20 70 140 0 -150 1").startswith("ok")
    assert terminal.ask("W") == "a"
    q = np.array(shared.status()["reference"])
    six = numbers(chain("pa10").forward(q), EULER if letter == "K" else RPY)
    assert terminal.ask(pose_request(letter, six).encode().decode().strip()).startswith("ok")
    assert terminal.ask("W") == "a"
    assert np.abs(np.subtract(shared.status()["reference"], q)).max() < 1e-5


def test_a_target_in_motion_replaces_the_one_before(terminal, shared):
    at = time.monotonic()
    first = terminal.ask("j 30 25 75 0 80 0 0.1")  # slowly: it is still on its way when the second one comes
    wait_for(lambda: shared.status()["q"][0] > 0.03, 5, "the motion")
    second = terminal.ask("j -20 20 75 0 80 0")
    assert (first[:2], second[:2]) == ("ok", "ok")
    assert terminal.ask("W") == "a"
    assert [r["end"] for r in journal(shared, "end", at)] == ["replaced", "done"]
    assert np.degrees(shared.status()["q"]) == pytest.approx([-20, 20, 75, 0, 80, 0], abs=0.05)


def test_hold_is_taken_during_a_wait_and_a_program(terminal, shared):
    terminal.say("j 90 0 60 0 60 0", "W")
    assert terminal.hear().startswith("ok")
    wait_for(lambda: shared.status()["moving"], 5, "the motion")
    assert {terminal.ask("h"), terminal.hear()} == {"ok hold", "a"}
    assert terminal.ask("p 1").startswith("ok program 1")
    assert terminal.ask("w") == "b"
    assert terminal.ask("j 0 0 0 0 0 0").startswith("e busy program 1")
    wait_for(lambda: shared.status()["moving"], 5, "the program's motion")
    assert terminal.ask("h") == "ok hold"
    before = len(journal(shared, "motion"))
    wait_for(lambda: not shared.status()["moving"], 2, "rest")
    assert shared.status()["mode"] == "NO_CTRL"
    over(shared, "program")
    assert len(journal(shared, "motion")) == before, "a program that was held does not go on"


def test_a_program_is_checked_as_a_whole_before_it_moves(terminal, shared):
    before = len(journal(shared, "motion"))
    terminal.say("u 77", "j 0 25 75 0 80 0", "k 500 160 -50 180 0 180", ".")
    assert terminal.hear() == "ok program 77 2 lines"
    assert "step 2" in (said := terminal.ask("p 77"))
    assert "the table" in said
    terminal.say("u 78", "j 1 2", ".")
    assert terminal.hear().startswith("e form line 1")
    assert terminal.ask("p 78").startswith("e range there is no program 78")
    assert len(journal(shared, "motion")) == before


def test_garbage_is_answered_and_moves_nothing(terminal, shared):
    before = len(journal(shared, "motion"))
    for line in ("", "x", "j 1 2 3", "j 1 2 3 4 5 nan", "k 1 2 3 4 5 6 9", "g 7", "\x00\x01", "j é 0 0 0 0 0"):
        assert terminal.ask(line).startswith("e "), line
    assert terminal.ask("w") == "a"
    assert len(journal(shared, "motion")) == before


def test_half_a_line_is_no_command(shared, terminal):
    before = len(journal(shared, "motion"))
    terminal.socket.sendall(b"j 0 0 0 0 0 0")
    at = time.monotonic()
    terminal.close()
    ended = wait_for(lambda: journal(shared, "disconnected", at), 5, "the end of the connection")
    assert ended[0]["cause"].startswith("half a line")
    assert len(journal(shared, "motion")) == before


@pytest.mark.asvs("1.3.3", "1.4.2")
@pytest.mark.parametrize(
    "line",
    [
        "C 1e308 0 0 0 0 0", "J 1e308 0 0 0 0 0", "J -1e308 1e308 0 0 0 0", "j 1e30 0 0 0 0 0", "k 1e308 0 0 0 0 0",
        "l 1e308 0 0 0 0 0", "K 0 0 0 0 0 1e308", "l 500 160 1e5 180 0 180", "j 0 0 0 0 0 0 1e308", "p 1e308", "p 1.5",
        "g 1e308", "g 0.5", "u 1e308", "i 1e308", "i -1", "i 1.5", "b 1e308 0 0 1 1 1 wall",
    ],
)  # fmt: skip
def test_a_number_beyond_its_bounds_is_refused_by_name(terminal, shared, line):
    motions = len(journal(shared, "motion"))
    said = terminal.ask(line)
    assert said.startswith("e range "), said
    assert "must be" in said, "it names value, range and unit"
    assert terminal.ask("w") == "a"
    assert np.all(np.isfinite(shared.status()["q"]))
    assert len(journal(shared, "motion")) == motions


@pytest.mark.parametrize("line", ["E", "R 2", "d 1"])
def test_a_program_word_is_no_command_of_its_own(terminal, shared, line):
    assert terminal.ask(line).startswith("e form "), line
    assert terminal.ask("w") == "a", "the client is still served, and nothing runs"


@pytest.mark.asvs("1.3.3")
@pytest.mark.parametrize(
    "raw", [b"\x00", b"j 0 0\x00 0 0 0 0", b"\xff\xfe", b"w\x0bw", b"\xc3\x28", b"j " + b"1" * 5000, b"\x1b[2J", b"j 1_0 0 0 0 0 0"]
)  # fmt: skip
def test_bytes_that_are_no_line_are_answered_and_the_next_line_is_heard(terminal, raw):
    terminal.socket.sendall(raw + b"\nw\n")
    assert terminal.hear().startswith("e form ")
    assert terminal.hear() == "a"


@pytest.mark.asvs("16.5.2")
@pytest.mark.parametrize("line", ["p 1", "J 0 0 0 0 0 20", "j 60 25 75 0 80 0 0.1", "l 500 160 300 180 0 180 0.05"])
def test_the_end_of_the_only_clients_connection_holds_at_once(terminal, shared, line):
    """A reset, the hardest end that a client can make."""
    assert terminal.ask(line).startswith("ok")

    def moving():
        if line.startswith("J"):  # a velocity ends by itself, sooner than a busy machine looks
            terminal.ask(line)
        return shared.status()["moving"]

    wait_for(moving, 5, "a motion")
    terminal.say("k 600 0 300 180 0 180", "p 1")  # the rest of the row does not begin either
    closed = time.monotonic()
    terminal.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    terminal.lines.close()
    terminal.socket.close()
    wait_for(lambda: journal(shared, "disconnected", closed), 5, "the end is noticed")
    held = journal(shared, "hold", closed)
    assert held, "the end of the connection holds"
    assert held[0]["t"] - closed < 0.5
    wait_for(lambda: not shared.status()["moving"], 3, "rest")
    assert len([r for r in journal(shared, "rest", closed) if r["t"] > held[0]["t"]]) <= 1
    over(shared, "client", "program")
    assert not [r for r in journal(shared, "motion", closed) if r["t"] > held[0]["t"]], "nothing goes on"
    assert not shared.status()["moving"]
    assert shared.status()["mode"] == "NO_CTRL"


@pytest.mark.asvs("2.3.3")
def test_an_upload_that_is_cut_off_changes_nothing(terminal, shared):
    terminal.say("u 50", "g 0", "g 1", ".")
    assert terminal.hear() == "ok program 50 2 lines"
    before = (shared.folder / "programs.json").read_text()
    terminal.say("u 50", "j 0 25 75 0 80 0")
    terminal.socket.sendall(b"j 0 2")
    at = time.monotonic()
    terminal.close()
    wait_for(lambda: journal(shared, "disconnected", at), 5, "its last byte was read")
    assert (shared.folder / "programs.json").read_text() == before
    other = Terminal(shared)
    assert other.ask("p 50").startswith("ok program 50 2.0 s"), "in memory too"
    other.ask("W")
    other.close()


def test_an_upload_that_is_wrong_is_read_to_its_dot_and_changes_nothing(terminal, shared):
    terminal.say("u 51", "g 0", ".")
    assert terminal.hear() == "ok program 51 1 lines"
    before = (shared.folder / "programs.json").read_text()
    for lines in (
        ["j 1 2"],
        ["g 0"] * 600,
        ["g 0", "x" * 3000],
        ["g 0 # é"],
        ["g 0", "#\x00"],
        ["d 1e308"],
        ["R 1e308"],
    ):
        terminal.say("u 51", *lines, ".")
        assert terminal.hear().startswith("e "), lines[0]
        assert terminal.ask("w") == "a", "no line of the program was taken for a command"
    assert (shared.folder / "programs.json").read_text() == before


def test_a_hold_is_heard_in_the_middle_of_an_upload(terminal, shared):
    assert terminal.ask("j 60 25 75 0 80 0 0.1").startswith("ok")
    wait_for(lambda: shared.status()["moving"], 5, "a motion")
    terminal.say("u 52", "g 0")
    at = time.monotonic()
    assert terminal.ask("h") == "ok hold"
    assert journal(shared, "hold", at), "it was no line of the program"
    terminal.say("g 1", ".")
    assert terminal.hear() == "ok program 52 2 lines"
    wait_for(lambda: not shared.status()["moving"], 3, "rest")


def test_a_hold_overtakes_a_row_of_lines_and_what_stood_before_it_does_not_begin(terminal, shared):
    at = time.monotonic()
    terminal.say(*["k 500 160 300 180 0 180"] * 40, "h")
    said = [terminal.hear() for _ in range(41)]
    assert "ok hold" in said[:20], "it did not wait for its place"
    assert said[-1].startswith("e busy a hold came before")
    held = journal(shared, "hold", at)[0]["t"]
    assert not [r for r in journal(shared, "motion", at) if r["t"] > held]


def test_many_waits_cost_one_thread_and_each_is_answered(terminal, shared):
    terminal.ask("j 30 25 75 0 80 0 0.1")

    def threads():
        """Return how many there are beside those that answer questions like this one."""
        names = shared.status()["threads"]
        return sum(not name.endswith("(process_request_thread)") for name in names)

    before = threads()
    terminal.say(*["W"] * 50)
    assert terminal.ask("w") == "b", "answered after all of them were taken"
    assert threads() <= before + 1
    assert [terminal.hear() for _ in range(50)] == ["a"] * 50


def test_a_client_that_does_not_read_is_cut_off_and_the_arm_held(terminal, shared):
    """Its answers fill every buffer; a hold must not wait for them."""
    terminal.say("u 53", *["j 50 25 75 0 80 0 0.05", "j 0 25 75 0 80 0 0.05"] * 2, ".")
    assert terminal.hear() == "ok program 53 4 lines"
    assert terminal.ask("p 53").startswith("ok program 53 1")  # more than 100 s, longer than the cutting off
    at = time.monotonic()
    terminal.socket.settimeout(20)
    with contextlib.suppress(OSError):
        while time.monotonic() < at + 20:
            terminal.socket.sendall(b"s\n" * 2000)
    wait_for(lambda: journal(shared, "disconnected", at), 20, "it is cut off")
    assert journal(shared, "hold", at)
    assert not journal(shared, "program_end", at), "it was on its way"
