"""The files through which a click goes to the wire are those that the docs name."""

import re
import threading
from pathlib import Path

from tests.world.seeds import hunt
from tests.world.web import AT_ROBOT, Browser, Sockets

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/explanation/commands.md").read_text()
MOST = 30
WIRE = "robots/kit/drivers/serial_line.py"
# Each begins a part of the path; what it calls belongs to the path.
BEGIN = {
    ("portal/live/robot_socket.py", "take"), ("portal/live/actions.py", "act"), ("workers/authority/lane.py", "wake"),
    ("workers/commands/run.py", "run_one"),
}  # fmt: skip
# From the top; a file calls files of its own room and of rooms below, and functions that were handed to it.
ROOMS = (
    "portal/live", "workers/commands", "workers/door", "workers/authority", "robots/services", "robots/grants",
    "robots/bus", "robots/models", "robots/people", "robots/prepared", "robots/kit/drivers", "robots/kit",
)  # fmt: skip
UP = {
    ("robots/kit/contract/values.py", "check"): "the robot's own check, which its spec names",
    ("robots/kit/drivers/serial_line.py", "called"): "the permit, asked last before the byte",
}


def own(code):
    """Return the name of a file of ours, from the top of the repository; empty for others."""
    name = code.co_filename
    return (
        name[len(str(ROOT)) + 1 :]
        if name.startswith((f"{ROOT}/portal/", f"{ROOT}/robots/", f"{ROOT}/workers/"))
        else ""
    )


def room(name):
    """Return how far below the top the room of a file is."""
    return next(at for at, start in enumerate(ROOMS) if name.startswith(start))


class Passed:
    """Notes each of our files in which something is called for the command, until its first byte is written."""

    def __init__(self):
        self.files, self.up, self.on = set(), set(), False

    def __call__(self, frame, event, _):
        if not self.on or event != "call":
            return
        if frame.f_code.co_name == "write" and own(frame.f_back.f_code) == WIRE:
            self.on = False  # the first byte
        if not self.on or not (name := own(frame.f_code)):
            return
        caller = frame
        while caller is not None and (own(caller.f_code), caller.f_code.co_name) not in BEGIN:
            caller = caller.f_back
        if caller is not None:
            self.files.add(name)
            if (back := own(frame.f_back.f_code)) in self.files and room(name) < room(back):
                self.up.add((back, frame.f_code.co_name))


def test_a_click_passes_the_files_that_the_docs_name_and_no_more(worlds):
    passed = Passed()

    def click(portal):
        portal.ready()
        page = Browser(Sockets(portal.world), portal.people["ada"]).open(AT_ROBOT.format(portal.slug))
        portal.grant()
        portal.until(lambda: page.snapshot.get("me", {}).get("can", {}).get("drive"), 20, "the controls")
        assert portal.final(portal.move()).state == "completed"  # from now on what is read once is read
        portal.world.sleep(1.0)  # until what ends with that command has ended
        begun = len(portal.motions())
        passed.on = True
        page.say("command", kind="move", seq=2, args=portal.place())
        portal.until(lambda: len(portal.motions()) > begun, 20, "the motion")
        passed.on = False

    threading.setprofile(passed)
    try:
        hunt(worlds, 1, click)
    finally:
        threading.setprofile(None)
    step = re.search(r"^\| Step \|.*?\n\n", PAGE, re.MULTILINE | re.DOTALL)[0]
    assert set(passed.files) == set(re.findall(r"`([\w/]+\.py)`", step))
    assert len(passed.files) <= MOST
    assert {(file, called) for file, called in passed.up if called != "<lambda>"} == set(UP)
