"""Commands in bytes over a page's real socket: carried out as those in JSON, and nothing is lost by what is wrong."""

import json

import pytest

from robots.models import Command
from tests.environment import ROOT
from tests.world.seeds import hunts
from tests.world.web import AT_ROBOT, Browser, Page, Sockets

pytestmark = pytest.mark.parametrize("which", ["pa10"], indirect=True)
VECTORS = json.loads((ROOT / "tests/vectors/command_packets.json").read_text())["commands"]


def packed(what):
    """Return the bytes of a command, and what they say."""
    one = next(one for one in VECTORS if one["what"] == what)
    return bytes.fromhex(one["hex"]), one["read"]


@hunts(1, 3, 30)
def test_a_command_in_bytes_is_carried_out_and_wrong_bytes_cost_nothing(portal):
    portal.grant()
    page = Browser(Sockets(portal.world), portal.people["ada"]).open(AT_ROBOT.format(portal.slug))
    portal.until(lambda: page.snapshot.get("me", {}).get("can", {}).get("drive"), 20, "the controls")
    data, said = packed("joints with speed and picture")
    for wrong in (data[:-1], data + b"\0", bytes((8, data[1] ^ 1)) + data[2:], b"\x08"):
        page.say_bytes(wrong)
    page.say_bytes(data)
    portal.until(lambda: len(page.answers) == 5, 20, "the answers")
    assert [(one["to"], one["ok"]) for one in page.answers] == [("command", False)] * 4 + [("command", True)]
    assert all(one["text"].startswith("That command was not understood: ") for one in page.answers[:4])
    assert page.answers[4]["seq"] == said["seq"]
    (command,) = Command.objects.filter(kind="joints", grant__holder=portal.people["ada"])
    assert (command.client_seq, command.args) == (said["seq"], said["args"])
    assert portal.final(command).state == "completed", command.reason
    assert page.code is None, "the socket stays open"


@hunts(1, 1, 3)
def test_a_strangers_command_in_bytes_is_refused(portal):
    portal.ready()
    sockets = Sockets(portal.world)
    for _ in range(2):  # for the second one nothing is read from the database
        page = Page(sockets, AT_ROBOT.format(portal.slug))
        portal.until(lambda page=page: page.snapshot, 10, "the snapshot")
        page.say_bytes(packed("without arguments")[0])
        portal.until(lambda page=page: page.answers, 10, "the answer")
        assert page.answers[0]["text"] == "Sign in first."
    page.say_bytes(b"\x01" * 40)
    portal.until(lambda: page.code == 4400, 10, "the end: none of our pages sends this")
