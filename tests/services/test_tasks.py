"""Tasks of the museum arm on the portal's side: saved as a language of their own, previewed and judged by the objects."""

import json
from datetime import timedelta

import pytest

from accounts.services import preview_job
from queueing.services import Asker, ask
from robots import bus, services
from robots.kit import previews
from robots.kit.arms.described import posture
from robots.kit.arms.objects import objects_of
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, NotPermitted, OutOfWorkspace
from robots.kit.contract.objects import KnownObjects, Placed
from robots.kit.contract.streams import StreamPacket, pack
from robots.kit.description import load
from robots.models import Command, Lease, Program
from robots.services import programs
from robots.states import GrantKind
from tests.services.browsers import signed_in

pytestmark = [
    pytest.mark.service, pytest.mark.django_db, pytest.mark.parametrize("which", ["pa10"], indirect=True),
]  # fmt: skip
READY = tuple(posture(load("pa10"), "ready"))
TEXT = "put red on yellow\nmove ready"


@pytest.fixture
def red_on_yellow(robot, redis_server):
    """Publish the packets of an owner whose arm has put the red block on the yellow one."""
    table = objects_of("pa10")
    places = {table.objects[name].number: placed for name, placed in table.first().items()}
    places[table.objects["red"].number] = Placed((0.56, 0.05, 0.06))
    data = KnownObjects(table.box).key(places)
    assert bus.publish_stream(robot.slug, 0, [pack(StreamPacket(0, 1, 1000, True, data))], from_key=True)
    yield
    bus.connection().flushall()


def foreseen(robot, user, text):
    return previews.compute(preview_job(robot, user, "task", {"text": text}, READY))


def test_a_task_is_saved_as_a_language_of_its_own(robot, people):
    ada = people["ada"]
    task = programs.save(robot, ada, "Tower", TEXT, False, SYSTEM.now(), kind="task")
    lines = programs.save(robot, ada, "Wave", "g 0", False, SYSTEM.now(), kind="program")
    assert (task.kind, lines.kind) == ("task", "")
    assert [list(programs.visible(robot, ada, kind)) for kind in ("task", "program", "")] == [[task], [lines], [lines]]
    assert set(programs.visible(robot, ada)) == {task, lines}
    with pytest.raises(BadRequest, match="no programs of that kind"):
        programs.save(robot, ada, "Other", TEXT, False, SYSTEM.now(), kind="jog_tool")
    browser, path = signed_in(ada), f"/robots/{robot.slug}/programs/"
    names = [[p["name"] for p in browser.get(path + query).json()["programs"]] for query in ("", "?kind=task")]
    assert names == [["Wave"], ["Tower"]]
    assert browser.get(path + "?kind=jog_tool").status_code == 400
    sent = browser.post(
        path, json.dumps({"name": "More", "text": TEXT, "kind": "task"}), content_type="application/json"
    )
    assert Program.objects.get(pk=sent.json()["id"]).kind == "task"


def test_a_saved_task_is_run_by_its_own_kind_alone(robot, people, owned):
    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
    saved = programs.save(robot, people["ada"], "Tower", TEXT, False, SYSTEM.now(), kind="task")
    command = services.issue(robot.slug, people["ada"], "task", {"program": saved.pk}, 1).command
    assert command.args == {"text": TEXT}
    with pytest.raises(BadRequest, match="no such program"):
        services.issue(robot.slug, people["ada"], "program", {"program": saved.pk}, 2)


def test_the_gallery_has_the_tasks_of_the_robots_package(robot, people):
    programs.load_gallery(robot, SYSTEM.now())
    assert set(programs.visible(robot, None, "task").values_list("name", flat=True)) == {
        "Tower of three",
        "There and back",
    }
    assert programs.visible(robot, None, "program").count() == 3
    for one in programs.visible(robot, None, "task"):
        assert foreseen(robot, people["kim"], one.text)["ok"], one.name


def test_a_preview_begins_with_the_objects_as_they_are_now(robot, people, red_on_yellow):
    found = foreseen(robot, people["ada"], "grasp yellow")
    assert (found["ok"], found["text"]) == (False, "Line 1, grasp yellow: red lies on yellow.")
    found = foreseen(robot, people["ada"], "put red at 450 250\ngrasp yellow")
    assert (found["ok"], set(found["steps"])) == (True, {0, 1, 2})


def test_a_preview_begins_with_the_first_places_where_nothing_is_known(robot, people):
    assert foreseen(robot, people["ada"], "grasp yellow")["ok"]
    assert "Line 1: 'lift' is no step" in foreseen(robot, people["ada"], "lift red")["text"]


def test_a_task_that_cannot_be_done_is_refused_before_anybody_waits(robot, people, red_on_yellow):
    Lease.objects.create(robot=robot, epoch=5, expires_at=SYSTEM.now() + timedelta(days=9))
    with pytest.raises(OutOfWorkspace, match="Line 1, grasp yellow: red lies on yellow."):
        ask(robot, Asker(user=people["ada"]), "task", {"text": "grasp yellow"}, SYSTEM.now())
    with pytest.raises(BadRequest, match="Line 1: there is no object pink"):
        ask(robot, Asker(user=people["ada"]), "task", {"text": "grasp pink"}, SYSTEM.now())
    job = ask(robot, Asker(user=people["ada"]), "task", {"text": "put red at 450 250"}, SYSTEM.now())
    assert job.kind == "task"


def test_the_page_knows_the_objects_and_the_box_of_their_packets(robot, people):
    page = signed_in(people["ada"]).get(f"/robots/{robot.slug}/").content.decode()
    for told in ('"name": "red"', '"objects_box"', '"name": "beliefs"'):
        assert told in page


PLACE = {"kind": "amend", "object": "0", "x": "0.45", "y": "0.25", "z": "0.02", "yaw": "0"}


def test_staff_correct_a_place_on_the_robots_page_of_the_admin(robot, people, owned):
    browser, path = signed_in(people["kim"]), f"/admin/robots/robot/{robot.pk}/"
    page = browser.get(f"{path}change/").content.decode()
    assert "Correct an object" in page
    assert "0 red, 1 yellow, 2 blue, 3 green." in page
    answer = browser.post(f"{path}do/setting/", PLACE, follow=True).content.decode()
    assert "the command history shows its result" in answer
    command = Command.objects.get()
    assert (command.kind, command.lane) == ("amend", "config")
    assert command.args == {"object": 0.0, "x": 0.45, "y": 0.25, "z": 0.02, "yaw": 0.0}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"x": "9"}, "x must lie between -1 and 1 m"),
        ({"x": "nan"}, "The value x must be a number."),
        ({"x": ""}, "The value x must be a number."),
        ({"object": "0.5"}, "object must be a whole number."),
        ({"object": "4"}, "object must lie between 0 and 3"),
        ({"kind": "task"}, "This robot has no such setting."),
        ({"kind": ""}, "This robot has no such setting."),
    ],
)
def test_a_place_that_cannot_be_is_refused_in_words(robot, people, owned, change, says):
    answer = signed_in(people["kim"]).post(f"/admin/robots/robot/{robot.pk}/do/setting/", PLACE | change, follow=True)
    assert says.lower() in answer.content.decode().lower()
    assert not Command.objects.exists()


def test_nobody_else_corrects_a_place(robot, people, owned):
    answer = signed_in(people["ada"]).post(f"/admin/robots/robot/{robot.pk}/do/setting/", PLACE)
    assert answer.status_code in (302, 403)
    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
    args = {name: float(value) for name, value in PLACE.items() if name != "kind"}
    with pytest.raises(NotPermitted):
        services.issue(robot.slug, people["ada"], "amend", args, 1)
    assert not Command.objects.exists()
