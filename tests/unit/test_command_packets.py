"""Commands in bytes: what a page writes is read to half a step, and any other bytes are refused with a sentence."""

import json

import pytest
from django.conf import settings
from hypothesis import example, given
from hypothesis import strategies as st

from portal.live.messages import Command, Keep, NotUnderstood, Ping, Released
from portal.live.people import Role
from portal.live.pieces import JoinedText
from portal.live.robot_socket import RobotSocket
from robots.kit.contract.command_packet import CommandLayout
from robots.kit.contract.spec import Argument, CommandKind, Spec
from tests.command_vectors import SPECS, VECTORS

NOW = 1_764_360_000_000
MOST = 24  # bytes of a motion of an arm


@pytest.mark.parametrize("one", VECTORS["commands"], ids=lambda one: one["what"])
def test_a_command_is_read_as_the_browser_packs_it(one):
    spec, command = SPECS[one["robot"]], one["command"]
    layout = CommandLayout.of(spec)
    assert json.loads(json.dumps(layout.facts())) == VECTORS["layouts"][one["robot"]]
    if one["hex"] is None:
        return
    data = bytes.fromhex(one["hex"])
    read = layout.decode(data, one["now_ms"])
    assert len(data) <= MOST
    assert (read.kind, read.seq, read.seen_ms) == (command["kind"], command["seq"], command.get("seen", 0))
    assert read.args == one["read"]["args"]
    kind = spec.command(command["kind"])
    for argument in kind.arguments:
        if argument.name not in command["args"]:
            assert argument.name not in read.args
            continue
        wanted, found = command["args"][argument.name], read.args[argument.name]
        assert argument.low <= found <= argument.high
        assert abs(found - wanted) <= (argument.high - argument.low) / 2**17
        assert wanted != 0 or found == 0 or argument.name in spec.joints, "no motion where none was asked for"


@pytest.mark.parametrize("one", [one for one in VECTORS["commands"] if one["hex"]], ids=lambda one: one["what"])
def test_a_command_that_is_cut_off_or_goes_on_or_is_of_other_commands_is_refused(one):
    layout, data = CommandLayout.of(SPECS[one["robot"]]), bytes.fromhex(one["hex"])
    for wrong in (*(data[:n] for n in range(len(data))), data + b"\0", data + bytes(300), b"\x09" + data[1:]):
        with pytest.raises(ValueError, match=r"this is no command|the end is missing|something follows its end"):
            layout.decode(wrong, one["now_ms"])
    with pytest.raises(ValueError, match="the robot's commands have changed"):
        layout.decode(bytes((8, data[1] ^ 1)) + data[2:], one["now_ms"])


@pytest.mark.parametrize("one", [one for one in VECTORS["holds"] if one["hex"]], ids=lambda one: one["what"])
def test_a_keep_alive_is_read_as_the_browser_packs_it_and_nothing_else_is(one):
    spec, message = SPECS[one["robot"]], one["message"]
    layout, data = CommandLayout.of(spec), bytes.fromhex(one["hex"])
    read = layout.decode_hold(data)
    assert len(data) <= MOST
    assert (read.seq, read.held) == (message["seq"], message["t"] == "keep")
    asked = message.get("args", {})
    assert read.args == pytest.approx(asked, abs=6.4 / 2**17)
    assert all(read.args[name] == 0 for name, value in asked.items() if value == 0)
    for wrong in (*(data[:n] for n in range(len(data))), data + b"\0", data + bytes(300), b"\x08" + data[1:]):
        with pytest.raises(ValueError, match=r"this is no command|the end is missing|something follows its end"):
            layout.decode_hold(wrong)
    with pytest.raises(ValueError, match="the robot's commands have changed"):
        layout.decode_hold(bytes((10, data[1] ^ 1)) + data[2:])


@given(st.sampled_from(sorted(SPECS)), st.binary(max_size=300))
def test_any_bytes_are_a_keep_alive_within_its_ranges_or_refused(name, data):
    spec = SPECS[name]
    layout = CommandLayout.of(spec)
    try:
        read = layout.decode_hold(bytes((10, layout.mark)) + data)
    except ValueError as error:
        assert 5 < len(str(error)) < 100
        return
    assert 1 <= read.seq < 1 << 16
    assert not read.args or read.held
    ranges = {a.name: a for a in spec.commands[data[0] >> 1].arguments}
    assert all(ranges[n].low <= value <= ranges[n].high for n, value in read.args.items())


@given(st.sampled_from(sorted(SPECS)), st.binary(max_size=300), st.booleans())
@example("nobody", b"", True)
def test_any_bytes_are_a_command_within_its_ranges_or_refused(name, data, marked):
    spec = SPECS.get(name, Spec("nobody", ()))
    layout = CommandLayout.of(spec)
    if marked:
        data = bytes((8, layout.mark)) + data
    try:
        read = layout.decode(data, NOW)
    except ValueError as error:
        assert 5 < len(str(error)) < 100
        return
    kind = spec.command(read.kind)
    ranges = {argument.name: argument for argument in kind.arguments}
    assert 1 <= read.seq < 1 << 16
    assert 0 <= read.seen_ms <= NOW + 60_000
    assert all(ranges[name].low <= value <= ranges[name].high for name, value in read.args.items())
    assert {a.name for a in kind.arguments if a.required} <= read.args.keys()


def test_texts_and_large_whole_numbers_are_left_to_json():
    arguments = (
        Argument("text", "", 0, 9, required=False, text=True), Argument("large", "", 0, 2.0**40, whole=True),
        Argument("same", "m", 1.0, 1.0),
    )  # fmt: skip
    ((_, fields),) = CommandLayout.of(Spec("R", (CommandKind("go", "Go", arguments),))).kinds
    assert [field.bits for field in fields] == [0, 0, 18]
    assert fields[2].number(0) == 1.0


def socket(layout, stranger=False):
    made = RobotSocket.__new__(RobotSocket)
    made.joined = JoinedText()
    made.layout, made.role, made.scope = layout, Role(7, stranger), {"cookies": {settings.SESSION_COOKIE_NAME: "k"}}
    return made


def test_a_socket_reads_commands_in_bytes_and_json_alike_and_says_what_is_wrong():
    one = next(one for one in VECTORS["commands"] if one["what"] == "without arguments")
    data, layout = bytes.fromhex(one["hex"]), CommandLayout.of(SPECS[one["robot"]])
    known = socket(layout)
    assert known.read(None, data) == Command(kind="ready", seq=2)
    assert known.read('{"t": "command", "kind": "ready", "seq": 2}', None) == Command(kind="ready", seq=2)
    for made, sent, words in (
        (known, data[:3], "this is no command; reload"), (socket(None, True), data, "Sign in first"),
        (socket(None), data, "could not be read; reload"),
    ):  # fmt: skip
        with pytest.raises(NotUnderstood, match=words) as refused:
            made.read(None, sent)
        assert (refused.value.to, refused.value.hopeless) == ("command", False)
    for sent in (b"", b"\x01abc", b"{}"):
        with pytest.raises(NotUnderstood) as refused:
            known.read(None, sent)
        assert refused.value.hopeless


def test_a_socket_reads_keep_alives_in_bytes_and_long_texts_in_pieces():
    found = {one["what"]: bytes.fromhex(one["hex"]) for one in VECTORS["holds"] if one["hex"]}
    arm = socket(CommandLayout.of(SPECS["Museum arm"]))
    assert arm.read(None, found["a joint is still held"]) == Keep(seq=7)
    assert arm.read(None, found["some values of it"]) == Keep(seq=300, args={"dz": pytest.approx(0.25, abs=1e-5)})
    assert arm.read(None, found["it was released"]) == Released(seq=7)
    assert arm.read(None, b"\x0b\x01\x02") == socket(None, True).read(None, b"\x0b\x01\x02") == Ping(n=258)
    with pytest.raises(NotUnderstood, match="this is no command"):
        arm.read(None, b"\x0b\x01\x02\x03")
    assert arm.read('\x071{"t": "command", "kind"', None) is None
    assert arm.read(None, found["it was released"]) == Released(seq=7)
    assert arm.read('\x072: "ready", "seq": 2}', None) == Command(kind="ready", seq=2)
