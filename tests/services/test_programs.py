"""Programs: permissions to see, save, delete and approve them; forbidden boxes; previews."""

import json

import pytest
from django.contrib.auth.models import Permission

from accounts.services import preview_job
from portal.live.messages import ROBOT, NotUnderstood
from robots import services
from robots.kit import previews
from robots.kit.arms.boxes import tidy_boxes
from robots.kit.arms.described import posture
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, NotPermitted, OutOfWorkspace
from robots.kit.description import load
from robots.models import Command, Program, Robot
from robots.services import programs
from robots.states import GrantKind
from tests.services.browsers import signed_in

pytestmark = [
    pytest.mark.service, pytest.mark.django_db, pytest.mark.parametrize("which", ["pa10"], indirect=True),
]  # fmt: skip


def preview(robot, user, *what):
    """Return what a page is told."""
    return previews.compute(preview_job(robot, user, *what))


TEXT = "g 0\nj 0 25 75 0 80 0"
READY = tuple(posture(load("pa10"), "ready"))


def save(robot, user, name="Wave", text=TEXT, shared=False, pk=None):
    return programs.save(robot, user, name, text, shared, SYSTEM.now(), pk)


def ask(user, method, robot, **what):
    return getattr(signed_in(user), method)(
        f"/robots/{robot.slug}/programs/", json.dumps(what), content_type="application/json"
    )


def test_ones_own_are_ones_own(robot, people):
    mine = save(robot, people["ada"])
    assert [p.pk for p in programs.visible(robot, people["ada"])] == [mine.pk]
    assert not programs.visible(robot, people["bob"]).exists()
    with pytest.raises(NotPermitted):
        save(robot, people["bob"], "Mine now", pk=mine.pk)
    with pytest.raises(NotPermitted):
        programs.delete(robot, people["bob"], mine.pk)
    with pytest.raises(BadRequest, match="no such program"):
        programs.visible_program(robot, people["bob"], mine.pk)
    assert Program.objects.get().author == people["ada"]


def test_a_shared_one_is_seen_once_staff_have_looked_through_it_and_again_after_each_change(robot, people):
    kept = save(robot, people["ada"], shared=True)
    assert not programs.visible(robot, people["bob"]).exists()
    with pytest.raises(NotPermitted):
        programs.approve(kept, people["ada"], True)
    staff = people["kim"]
    staff.user_permissions.add(Permission.objects.get(codename="change_program"))
    staff = type(staff).objects.get(pk=staff.pk)
    programs.approve(kept, staff, True)
    assert [p.name for p in programs.visible(robot, people["bob"])] == ["Wave"]
    save(robot, people["ada"], text=TEXT + "\nd 1", shared=True, pk=kept.pk)
    assert not programs.visible(robot, people["bob"]).exists(), "what was changed is looked through again"
    private = save(robot, people["ada"], "Private")
    with pytest.raises(BadRequest, match="not shared"):
        programs.approve(private, staff, True)


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [
        ("", TEXT, "a name"),
        ("x" * 61, TEXT, "at most 60"),
        ("Wave", "", "at least one step"),
        ("Wave", "g 0\n" * 3000, "6000"),
    ],
)
def test_what_cannot_be_saved_is_refused_in_words(robot, people, name, text, why):
    answer = ask(people["ada"], "post", robot, name=name, text=text)
    assert answer.status_code == 400
    assert why in answer.json()["error"]
    assert not Program.objects.exists()


def test_a_name_stands_once_and_there_is_an_end_to_how_many(robot, people):
    save(robot, people["ada"])
    assert save(robot, people["ada"]) == save(robot, people["ada"]), "a double press"
    with pytest.raises(BadRequest, match="of that name"):
        programs.save(
            robot, people["ada"], programs.visible(robot, people["ada"])[0].name, f"{TEXT}\n", True, SYSTEM.now()
        )
    for number in range(programs.MOST - 1):
        save(robot, people["ada"], f"n{number}")
    with pytest.raises(NotPermitted, match="delete one first"):
        save(robot, people["ada"], "one more")


def test_over_the_web(robot, people):
    assert ask(None, "post", robot, name="Wave", text=TEXT).status_code == 403
    made = ask(people["ada"], "post", robot, name="Wave", text=TEXT, shared=True).json()
    assert (made["mine"], made["approved"]) == (True, False)
    assert [p["name"] for p in signed_in(people["ada"]).get(f"/robots/{robot.slug}/programs/").json()["programs"]] == [
        "Wave"
    ]
    assert signed_in().get(f"/robots/{robot.slug}/programs/").json() == {"programs": []}
    for body in (b"{", b"[]", b'{"name": 3}', b'{"id": "x", "name": "a", "text": true}'):
        bad = signed_in(people["ada"]).post(f"/robots/{robot.slug}/programs/", body, content_type="application/json")
        assert bad.status_code in (200, 400), bad.content
    assert ask(people["bob"], "delete", robot, id=made["id"]).status_code == 403
    assert ask(people["ada"], "delete", robot, id=made["id"]).status_code == 200
    assert not Program.objects.filter(pk=made["id"]).exists()


def test_the_longest_program_is_saved_whatever_its_characters(robot, people):
    text = "\U0001f916" * programs.LONGEST
    answer = ask(people["ada"], "post", robot, name="\U0001f916" * 60, text=text)
    assert (answer.status_code, answer.json().get("text")) == (200, text)
    assert ask(people["ada"], "post", robot, name="More", text=text + "x").json()["error"].startswith("A program has")


def test_a_saved_program_is_run_as_the_text_it_had(robot, people, owned):
    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
    kept = save(robot, people["ada"])
    command = services.issue(robot.slug, people["ada"], "program", {"program": kept.pk}, 1).command
    assert command.args == {"text": TEXT}
    theirs = save(robot, people["bob"], "Bob's")
    with pytest.raises(BadRequest, match="no such program"):
        services.issue(robot.slug, people["ada"], "program", {"program": theirs.pk}, 2)
    for args in ({}, {"text": "x 1"}, {"text": ""}, {"text": "R 2"}, {"text": TEXT, "number": 2}, {"text": 7}):
        with pytest.raises(BadRequest):
            services.issue(robot.slug, people["ada"], "program", args, 3)
    assert Command.objects.count() == 1


def test_where_a_target_would_lead(robot, people):
    place = {"x": 0.5, "y": 0.16, "z": 0.15, "roll": 3.14159265, "pitch": 0.0, "yaw": 3.14159265}
    found = preview(robot, people["ada"], "pose", place, READY)
    assert found["tool"][-1] == pytest.approx((0.5, 0.16, 0.15), abs=1e-4)
    assert found["seconds"] > 0.2
    assert "the table" in preview(robot, people["ada"], "pose", place | {"z": -0.1}, READY)["text"]
    run = preview(robot, people["ada"], "program", {"text": "j 10 25 75 0 80 0\nd 2\nj 0 25 75 0 80 0"}, READY)
    assert set(run["steps"]) == {0, 1, 3}
    assert run["seconds"] > 2.0
    assert not Command.objects.exists()


def test_a_program_that_will_not_run_is_judged_with_step_and_time(robot, people):
    """By the judgement of missions: which step, when it would begin, and what is wrong with it."""
    text = "j 10 25 75 0 80 0\nd 2\nk 500 160 -50 180 0 180\nd 1"
    before = preview(robot, people["ada"], "program", {"text": text.partition("\nk")[0]}, READY)
    found = preview(robot, people["ada"], "program", {"text": text}, READY)
    (said,) = found["judgements"]
    assert (found["ok"], found["text"]) == (False, said["text"])
    assert (said["step"], said["refuses"]) == (3, True)
    assert said["at_s"] == pytest.approx(before["seconds"], abs=0.01) and said["at_s"] > 2.0
    assert said["text"].startswith("Step 3: ") and "the table" in said["text"]


@pytest.mark.parametrize(
    "message",
    [
        {"kind": "pose", "args": [], "from": list(READY)}, {"kind": "pose", "args": {}, "from": "x"},
        {"kind": "pose", "args": {"x": "a"}, "from": list(READY)}, {"kind": "fly", "args": {}, "from": list(READY)},
        {"kind": "joints", "args": {}, "from": [1e9] * 6}, {"kind": None, "args": {}, "from": list(READY)},
        {"kind": "ready", "args": {}, "from": [float("nan")] * 6}, {"kind": "ready", "args": {}, "from": [0.0] * 17},
    ],
)  # fmt: skip
def test_a_preview_of_nonsense_is_refused_in_words(robot, people, message):
    try:
        asked = ROBOT.decode(json.dumps({"t": "plan", **message}))
    except NotUnderstood as error:
        assert str(error).endswith(".")
        return
    found = preview(robot, people["ada"], asked.kind, dict(asked.args), tuple(asked.joints))
    assert not found["ok"]
    assert found["text"].endswith(".")


def test_a_box_of_staff_is_in_the_way_of_preview_and_command(robot, people, owned):
    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
    place = {"x": 0.5, "y": 0.16, "z": 0.15, "roll": 3.14159265, "pitch": 0.0, "yaw": 3.14159265}
    services.issue(robot.slug, people["ada"], "pose", place, 1)
    Robot.objects.update(settings={"boxes": [{"name": "the vase", "low": [0.4, 0.1, 0.0], "high": [0.6, 0.3, 0.3]}]})
    robot.refresh_from_db()
    with pytest.raises(OutOfWorkspace, match="the vase"):
        services.issue(robot.slug, people["ada"], "pose", place, 2)
    assert "the vase" in preview(robot, people["ada"], "pose", place, READY)["text"]


def test_boxes_are_checked_before_they_are_kept(robot):
    assert tidy_boxes([{"name": "vase", "low": [1, 1, 1], "high": [0, 0, 0]}]) == [
        {"name": "vase", "low": [0, 0, 0], "high": [1, 1, 1]}
    ]
    for bad in (
        {}, "x", [3], [{"name": ""}], [{"name": "a<b", "low": [0, 0, 0], "high": [1, 1, 1]}],
        [{"name": "a", "low": [0, 0], "high": [1, 1, 1]}], [{"name": "a", "low": [0, 0, 0], "high": [1, 1, 0]}],
        [{"name": "a", "low": [0, 0, True], "high": [1, 1, 1]}], [{"name": "a", "low": [0, 0, 0], "high": [1, 1, 99]}],
        [{"name": f"b{i}", "low": [0, 0, 0], "high": [1, 1, 1]} for i in range(21)],
    ):  # fmt: skip
        with pytest.raises(BadRequest):
            tidy_boxes(bad)


@pytest.mark.parametrize("who", ["eve", "mod"])
def test_a_preview_is_for_cleared_people_and_staff(robot, people, who):
    with pytest.raises(NotPermitted, match="clearance test"):
        preview(robot, people[who], "ready", {}, READY)
    for may in ("ada", "kim"):
        assert preview(robot, people[may], "ready", {}, READY)["ok"]


def test_a_name_turns_no_text_round(robot, people, client):
    saved = save(robot, people["ada"], "sq\u202euare\x1b\u200b")
    assert saved.name == "square"
    Program.objects.update(name="\u202eerauqs")  # of before
    client.force_login(people["ada"])
    assert client.get("/robots/pa10/programs/").json()["programs"][0]["name"] == "erauqs"
