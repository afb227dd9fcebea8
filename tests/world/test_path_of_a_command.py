"""The files through which a click goes to the wire are those that the docs name."""

import re
import threading
from pathlib import Path

from tests.world.seeds import hunt
from tests.world.web import AT_ROBOT, Browser, Sockets

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/explanation/commands.md").read_text()
MOST = 37
# Each begins a part of the path; what it calls belongs to the path.
BEGIN = {
    ("portal/live/robot_socket.py", "take"), ("portal/live/actions.py", "act"), ("workers/authority/lane.py", "wake"),
    ("workers/commands/dispatch.py", "run_one"),
}  # fmt: skip


def own(code):
    """Return the name of a file of ours, from the top of the repository; empty for others."""
    name = code.co_filename
    return (
        name[len(str(ROOT)) + 1 :]
        if name.startswith((f"{ROOT}/portal/", f"{ROOT}/robots/", f"{ROOT}/workers/"))
        else ""
    )


class Passed:
    """Notes each of our files in which something is called for the command, until its first byte is written."""

    def __init__(self):
        self.files, self.on = set(), False

    def __call__(self, frame, event, _):
        if not self.on or event != "call" or not (name := own(frame.f_code)):
            return
        if name == "robots/kit/drivers/mercury/line.py" and frame.f_code.co_name == "write":
            self.on = False
        caller = frame
        while caller is not None and (own(caller.f_code), caller.f_code.co_name) not in BEGIN:
            caller = caller.f_back
        if caller is not None:
            self.files.add(name)


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
