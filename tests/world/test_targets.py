"""Watchers are told where a command takes the robot, from when it is sent until it ends; late comers by their snapshot."""

from tests.world.seeds import hunts
from tests.world.web import AT_ROBOT, Page, Sockets


def opened(portal, sockets):
    """Return a stranger's page that has its snapshot."""
    page = Page(sockets, AT_ROBOT.format(portal.slug))
    portal.until(lambda: page.snapshot, 10, "the snapshot")
    return page


def told_of(page, command):
    """Return what the newest message about a command tells."""
    told = page.newest.get("command", {})
    return told if told.get("id") == command.pk else {}


@hunts(1, 5, 50)
def test_who_watches_knows_where_the_robot_goes_until_it_is_there(portal):
    portal.grant()
    sockets = Sockets(portal.world)
    page = opened(portal, sockets)
    command = portal.move()
    portal.until(lambda: told_of(page, command).get("target"), 10, "the target")
    target = told_of(page, command)["target"]
    assert target["place"] == {name: command.args[name] for name in ("x", "y")}
    assert target["words"].startswith("Move to "), "from where the robot was"
    late = opened(portal, sockets)
    known = next(c for c in late.snapshot["commands"] if c["id"] == command.pk)
    assert known["target"] == ({} if known["state"] == "completed" else target)
    assert portal.final(command).state == "completed"
    portal.until(lambda: told_of(page, command).get("state") == "completed", 10, "the end")
    assert told_of(page, command)["target"] == {}
    after = opened(portal, sockets)
    assert all(c["target"] == {} for c in after.snapshot["commands"])
