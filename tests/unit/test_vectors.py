"""Code that exists in Python and in TypeScript gives the same for the same vectors (frontend/tests/vectors.test.ts)."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from robots.kit.arms.commands import bounded
from robots.kit.arms.pose import matrix, numbers
from robots.kit.arms.tasks.parsing import BadTask
from robots.kit.arms.tasks.parsing import parse as parse_task
from robots.kit.arms.tasks.steps import write
from robots.kit.contract.channels import Scalar
from robots.kit.contract.compact import Layout
from robots.kit.contract.errors import OutOfWorkspace
from robots.kit.contract.objects import Box, KnownObjects, Placed
from robots.kit.contract.packet_chain import PacketChain
from robots.kit.contract.session import RobotState
from robots.kit.contract.streams import StreamPacket, pack, unpack
from robots.kit.contract.video import VideoPacket
from robots.kit.contract.video import pack as pack_video
from robots.kit.contract.video import unpack as unpack_video
from robots.kit.description import load
from robots.kit.drivers.irat.spec import spec as irat
from robots.kit.drivers.mercury import calibration
from robots.kit.drivers.mercury.checks import check_target
from robots.kit.drivers.mercury.scara import scara
from robots.kit.drivers.mercury.spec import spec as mercury
from robots.kit.drivers.pa10.checks import request_of
from robots.kit.drivers.pa10.protocol import Malformed, OutOfBounds, parse, program
from robots.kit.drivers.pa10.spec import spec as pa10
from robots.kit.packets import picture_packet, read_picture, state_packet, taken_ms
from robots.kit.recording.container import STATE, Tape
from robots.kit.recording.packets import picture_of, picture_packed, state_told
from robots.kit.recording.timeline import read_index, read_slice
from robots.states import COMMAND_FINAL, CommandState

VECTORS = Path(__file__).resolve().parents[1] / "vectors"


def read(name):
    return json.loads((VECTORS / f"{name}.json").read_text())


PACKETS, COMPACT = read("state_packets"), read("compact_states")
STREAMS, VIDEO = read("stream_packets"), read("video_packets")
LINES, PICTURES, POSES = read("pa10_lines"), read("picture_packets"), read("poses")
PLANE, PROGRAMS = read("mercury_plane"), read("pa10_programs")
ARM, DESCRIPTION = scara(PLANE), load("mercury")


def test_the_plane_is_that_of_the_arm():
    assert (PLANE["arm"], PLANE["sand"]) == (DESCRIPTION["arm"], DESCRIPTION["sand"])


@pytest.mark.parametrize("one", PLANE["forward"])
def test_elbow_and_tool(one):
    q = (*one["q"], 0.0, 0.0)
    assert ARM.elbow(q) == pytest.approx(one["elbow"], abs=1e-8)
    assert ARM.forward(q)[:2] == pytest.approx(one["tool"], abs=1e-8)


@pytest.mark.parametrize("one", PLANE["places"])
def test_places_on_and_off_the_sand(one):
    if not one["allowed"]:
        with pytest.raises(OutOfWorkspace):
            check_target(DESCRIPTION, one["x"], one["y"], 0.0)
        return
    assert ARM.elbow(check_target(DESCRIPTION, one["x"], one["y"], 0.0)) == pytest.approx(one["elbow"], abs=1e-8)


@pytest.mark.parametrize("one", PLANE["clicks"])
def test_what_a_click_means(one):
    found = calibration.target({"at": one["map"]}, tuple(one["pose"]), one["u"], one["v"], one["width"], one["height"])
    assert found == pytest.approx(one["target"], abs=1e-8)


@pytest.mark.parametrize("one", PROGRAMS, ids=lambda one: ascii(one["text"])[:30])
def test_programs_as_text(one):
    if "steps" in one:
        assert [[step.letter, *step.numbers] for step in program(one["text"])] == one["steps"]
        return
    with pytest.raises(Malformed) as refused:
        program(one["text"])
    found = re.match(r"line (\d+): ", str(refused.value))
    assert (int(found[1]) if found else None) == one["refused"]


@pytest.mark.parametrize("one", LINES["understood"], ids=lambda one: one["line"])
def test_a_typed_line_stands_for_the_command_that_sends_it(one):
    asked, args = parse(one["line"]), one["args"]
    bounded("pa10", one["kind"], args)
    if one["kind"] in ("joints", "pose", "line"):
        sent = request_of(one["kind"], args)
        assert (sent.letter, sent.numbers) == (asked.letter, pytest.approx(asked.numbers, abs=1e-9))
    else:
        assert (asked.letter, list(asked.numbers)) == ({"gripper": "g", "program": "p"}[one["kind"]], [*args.values()])


@pytest.mark.parametrize("line", LINES["refused"])
def test_a_typed_line_that_the_arm_refuses(line):
    with pytest.raises((Malformed, OutOfBounds)):
        parse(line)


@pytest.mark.parametrize("one", POSES)
def test_roll_pitch_and_yaw(one):
    found = numbers(np.array(one["matrix"]))
    assert found == pytest.approx(one["pose"], abs=1e-8)
    assert matrix(found) == pytest.approx(np.array(one["matrix"]), abs=1e-8)


@pytest.mark.parametrize("one", PICTURES, ids=lambda one: one["what"])
def test_a_recording_names_what_a_picture_tells(one):
    numbers, jpeg = (*one["joints"], *one["pose"], *one["twist"]), bytes.fromhex(one["jpeg"])
    packet = picture_packet(one["number"], one["at_ms"], one["still"], numbers, jpeg, one["camera"])
    told = picture_of(packet, len(one["joints"]), len(one["pose"]))
    assert [list(told.get(name, ())) for name in ("joints", "pose", "twist")] == [
        one["joints"], one["pose"], one["twist"]
    ]  # fmt: skip
    assert picture_packed(json.loads(json.dumps(told)), one["camera"]).hex() == one["hex"]


@pytest.mark.parametrize("one", PICTURES, ids=lambda one: one["what"])
def test_a_picture_is_packed_as_the_browser_reads_it(one):
    jpeg = bytes.fromhex(one["jpeg"])
    numbers = (*one["joints"], *one["pose"], *one["twist"])
    packet = picture_packet(one["number"], one["at_ms"], one["still"], numbers, jpeg, one["camera"])
    assert packet.hex() == one["hex"]
    assert (read_picture(packet), taken_ms(packet)) == (jpeg, one["at_ms"])


def test_a_recording_is_sliced_as_the_browser_reads_it(tmp_path):
    vectors = read("recording_slices")
    path, joints = tmp_path / "a.mcap", vectors["joints"]
    tape = Tape(path, {"robot": "r"})
    for one in vectors["messages"]:
        data, topic = bytes.fromhex(one["hex"]), one["topic"]
        camera = topic.startswith("camera/")
        told = state_told(data, joints, ()) if topic == STATE else picture_of(data) if camera else data
        tape.put(topic, (vectors["began_ms"] + one["after_ms"]) * 10**6, told)
    tape.close()
    index = read_index(path)
    assert (index.began_ms, index.needs) == (vectors["began_ms"], vectors["needs"])
    slices = [read_slice(path, index, n, joints, ()).hex() for n in range(len(index.needs))]
    assert slices == vectors["slices"]


def test_states_of_commands():
    known = read("command_states")
    assert known == {"states": [state.value for state in CommandState], "final": sorted(COMMAND_FINAL)}


@pytest.mark.parametrize("one", PACKETS, ids=lambda one: one["what"])
def test_a_state_is_packed_as_the_browser_reads_it(one):
    told = {name: float(value) for name, value in one["told"].items()}
    state = RobotState(
        0.0, tuple(one["joints"]), (), one["moving"], True, "", tuple(one["velocities"]), tuple(one["torques"]),
        one["mode"], told,
    )  # fmt: skip
    channels = tuple(Scalar(name, "", 0.0, 1.0) for name in one["channels"])
    packet = state_packet(one["number"], one["at_ms"], state, one["stopped"], channels, twist=tuple(one["twist"]))
    assert packet.hex() == one["hex"]


@pytest.mark.parametrize("one", STREAMS, ids=lambda one: one["what"])
def test_byte_streams_are_packed_and_chained_as_the_browser_reads_them(one):
    chains = {}
    for told in one["packets"]:
        packet = StreamPacket(
            told["stream"], told["number"], told["at_ms"], told["key"], bytes.fromhex(told["data"]), told["run"]
        )  # fmt: skip
        assert pack(packet).hex() == told["hex"]
        assert unpack(pack(packet)) == packet
        chains.setdefault(told["stream"], PacketChain(unpack)).add(pack(packet))
    assert {str(n): [unpack(data).data.hex() for data in c.packets] for n, c in chains.items()} == one["shown"]


@pytest.mark.parametrize("one", COMPACT, ids=lambda one: one["what"])
def test_a_compact_state_is_packed_as_the_browser_reads_it(one):
    layout = next(Layout.of(spec) for spec in (mercury(), pa10(), irat()) if spec.name == one["robot"])
    assert json.loads(json.dumps(layout.facts())) == one["layout"]
    state = RobotState(0.0, tuple(one["joints"]), (), one["moving"], True, mode=one["mode"])
    assert layout.encode(one["at_ms"], state, one["stopped"], one["told"]).hex() == one["hex"]


@pytest.mark.parametrize("one", VIDEO, ids=lambda one: one["what"])
def test_video_is_packed_and_followed_as_the_browser_reads_it(one):
    chains = {}
    for told in one["packets"]:
        back = 0 if told["follows"] is None else (told["number"] - told["follows"]) % 2**32
        number = told["number"] + (2**32 if back > told["number"] else 0)
        packet = VideoPacket(
            told["camera"], number, told["at_ms"], told["still"], bytes.fromhex(told["data"]), told["follows"], told["run"]
        )  # fmt: skip
        assert pack_video(packet).hex() == told["hex"]
        chain = chains.setdefault(told["camera"], PacketChain(unpack_video))
        added = chain.add(pack_video(packet))
        assert added is told["taken"]
        if not added:
            chain.clear()


def test_objects_are_packed_as_the_browser_reads_them():
    vectors = read("object_packets")
    writer, reader = (KnownObjects(Box(**{k: tuple(v) for k, v in vectors["box"].items()})) for _ in range(2))
    for one in vectors["packets"]:
        held = set(one.get("held", ()))
        objects = {int(n): Placed(tuple(at[:3]), tuple(at[3:]), n in held) for n, at in one["objects"].items()}
        data = writer.key(objects) if one["key"] else writer.delta(objects)
        assert data.hex() == one["hex"], one["what"]
        found = reader.take(data, one["key"]).objects
        assert {str(n) for n, p in found.items() if p.held} == held
        assert {str(n): [*p.place, *p.rotation] for n, p in found.items()} == {
            n: pytest.approx(told, abs=1e-8) for n, told in one["read"].items()
        }


@pytest.mark.parametrize("one", read("tasks"), ids=lambda one: one["text"][:30])
def test_a_task_is_read_as_the_page_reads_it(one):
    try:
        assert write(parse_task(one["text"])) == one["written"]
    except BadTask as error:
        assert str(error) == one["refused"]
