"""The admin's first page: a card for each robot with what the member of staff may see and do, and what waits for them."""

import re
from datetime import timedelta
from zoneinfo import ZoneInfo

import pytest
from django.contrib.auth.models import Permission
from django.urls import reverse

from accounts.models import User
from operatorlog import finds
from operatorlog import services as log
from operatorlog.models import Entry, Find, Visibility
from portal.live import actions
from portal.live.messages import Leave
from portal.web.staff.pending import MOST, pending
from queueing import services as queue
from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Frame, Grant, Incident, Program, Robot
from robots.services import programs
from robots.states import Cycle, GrantEnd, GrantKind
from tests.services.browsers import signed_in
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("owned")]
PAGES = ("/admin/", "/admin/live/")
VERB = re.compile(r"/do/(\w+)/")


def with_rights(name, *codes):
    made = User.objects.create_user(name, f"{name}@example.org", "correct horse 42", is_staff=True)
    made.user_permissions.set(Permission.objects.filter(codename__in=codes))
    return User.objects.get(pk=made.pk)


def shown(user, page="/admin/live/"):
    return signed_in(user).get(page).content.decode()


def card(text):
    return re.search(r"<article.*?</article>", text, re.DOTALL)[0]


def sent(user, robot, verb, **data):
    return signed_in(user).post(f"/admin/robots/robot/{robot.pk}/do/{verb}/", {"from": "first", **data})


@pytest.fixture
def entry(robot, people):
    now = SYSTEM.now()
    turn = drive(robot, people["ada"], now)
    frame = Frame.objects.create(robot=robot, grant=turn.grant, file="frames/a.jpg", taken_at=now, width=4, height=3)
    queue.end_turn(turn, GrantEnd.HOLDER, "x", now)
    turn.refresh_from_db()
    return log.write(turn, people["ada"], "A watch in the sand.", frame.pk, now)


@pytest.fixture
def program(robot, people):
    return Program.objects.create(
        robot=robot, author=people["ada"], name="nod", text="down", shared=True, changed_at=SYSTEM.now()
    )


@pytest.mark.parametrize("page", PAGES)
def test_a_card_says_who_drives_who_waits_and_what_happened_last(robot, people, page):
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    drive(robot, people["ada"], SYSTEM.now())
    queue.join(robot, people["bob"], SYSTEM.now())
    Incident.objects.create(robot=robot, at=SYSTEM.now(), code="x", text="The arm was silent.")
    text = card(shown(root, page))
    assert "In use" in text
    assert re.search(r"<dt>Drives</dt><dd>ada, until <time [^>]*>\d\d:\d\d:\d\d UTC</time></dd>", text)
    assert "1 waiting</a>: bob" in text
    assert "The arm was silent." in text
    assert {"stop", "lock_out", "maintenance"} <= set(VERB.findall(text))


def test_a_stop_that_is_not_confirmed_is_told_as_such(robot, people):
    services.stop(robot, people["kim"])
    assert "stop pressed, not confirmed" in card(shown(people["kim"]))
    Robot.objects.update(stop_confirmed=True)
    text = card(shown(people["kim"]))
    assert "<b>stopped</b>" in text
    assert "release" in VERB.findall(text)


def test_without_the_right_to_see_robots_there_are_no_cards(robot, people):
    for page in PAGES:
        text = shown(people["mod"], page)
        assert "<article" not in text
        assert robot.name not in text
        assert not VERB.findall(text)


def test_who_may_only_look_has_no_buttons(robot, people):
    Robot.objects.update(stop_latched=True, stopped_at=SYSTEM.now())
    text = shown(with_rights("vic", "view_robot", "view_incident"))
    assert robot.name in card(text)
    assert "<form" not in text


def test_names_of_people_who_wait_and_incidents_are_for_those_who_may_see_them(robot, people):
    queue.join(robot, people["ada"], SYSTEM.now())
    Incident.objects.create(robot=robot, at=SYSTEM.now(), code="x", text="The arm was silent.")
    text = shown(with_rights("vic", "view_robot"))
    assert "1 waiting" in text
    assert "ada" not in card(text)
    assert "The arm was silent." not in text


@pytest.mark.asvs("8.2.1")
@pytest.mark.parametrize(
    ("verb", "data"),
    [("stop", {}), ("lock_out", {"note": "x"}), ("maintenance", {"note": "x"}), ("end_maintenance", {})],
)
def test_no_verb_of_a_card_works_without_the_right_to_change_robots(robot, people, verb, data):
    services.start_grant(robot, GrantKind.STAFF, SYSTEM.now(), people["kim"])
    before = Robot.objects.filter(pk=robot.pk).values().get()
    for user in (people["ada"], people["mod"], with_rights("vic", "view_robot")):
        assert sent(user, robot, verb, **data).status_code == (403 if user.is_staff else 302)
    assert Robot.objects.filter(pk=robot.pk).values().get() == before
    assert Grant.objects.get().ended_at is None


def test_a_verb_of_a_card_leads_back_to_the_cards(robot, people):
    answer = sent(people["kim"], robot, "stop")
    assert answer["Location"] == reverse("admin:index")
    robot.refresh_from_db()
    assert robot.stop_latched
    assert sent(people["kim"], robot, "lock_out", note=" ")["Location"] == reverse("admin:index")
    robot.refresh_from_db()
    assert robot.cycle != Cycle.LOCKED_OUT, "a lock-out needs a note"


def test_maintenance_locks_out_with_the_note_and_leads_to_the_console_which_ends_it(robot, people):
    kim = people["kim"]
    drive(robot, people["ada"], SYSTEM.now())
    answer = sent(kim, robot, "maintenance", note="a new belt")
    assert answer["Location"] == robot.get_absolute_url()
    robot.refresh_from_db()
    assert (robot.cycle, robot.lockout_note) == (Cycle.LOCKED_OUT, "a new belt")
    grant = Grant.objects.get(ended_at=None)
    assert (grant.kind, grant.holder) == (GrantKind.STAFF, kim)
    text = card(shown(kim))
    assert "kim (maintenance)" in text
    assert f'href="{robot.get_absolute_url()}">Drive it' in text
    assert "end_maintenance" in VERB.findall(text)
    assert sent(kim, robot, "end_maintenance")["Location"] == reverse("admin:index")
    grant.refresh_from_db()
    robot.refresh_from_db()
    assert (grant.end_code, robot.cycle) == (GrantEnd.HOLDER, Cycle.LOCKED_OUT)
    assert {"maintenance", "lift"} <= set(VERB.findall(card(shown(kim))))


def test_end_in_the_console_ends_the_maintenance_turn_of_its_holder_alone(robot, people, monkeypatch):
    services.lock_out(robot, people["kim"], "a new belt")
    grant = services.start_maintenance(robot, people["kim"])
    monkeypatch.setattr(actions, "session_key", lambda scope: "s")
    for name in ("ada", "eve", "mod", "kim"):
        monkeypatch.setattr(actions, "current_user", lambda scope, name=name: people[name])
        answer = actions.act({}, robot.slug, Leave())
        grant.refresh_from_db()
        assert (grant.ended_at is not None) == (name == "kim"), name
    assert answer.text == "The maintenance turn is over. The robot stays locked out."


def test_a_robot_whose_worker_is_silent_is_not_locked_out_for_a_maintenance_turn_that_cannot_begin(
    robot, people, owned
):
    type(owned).objects.update(expires_at=None)
    sent(people["kim"], robot, "maintenance", note="a new belt")
    robot.refresh_from_db()
    assert robot.cycle != Cycle.LOCKED_OUT


def test_without_a_robot_the_page_says_how_to_begin(people):
    Robot.objects.all().delete()
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    assert "Add the first robot" in shown(root, "/admin/")
    assert "Add the first robot" not in shown(people["kim"], "/admin/"), "kim may not add one"


def test_what_waits_is_one_list_the_oldest_first_and_each_row_has_what_resolves_it(robot, people, entry, program):
    root, now = User.objects.create_superuser("root", "root@example.org", "correct horse 42"), SYSTEM.now()
    incident = Incident.objects.create(robot=robot, at=now - timedelta(hours=2), code="x", text="Silent.")
    Program.objects.update(changed_at=now - timedelta(hours=1))
    assert [one.kind for one in pending(root).items] == ["Incident", "Program", "Entry"]
    client = signed_in(root)
    page = client.get("/admin/").content.decode()
    assert entry.frame.url in page
    for one in pending(root).items:
        assert client.get(one.url).status_code == 200
        act = one.acts[0]
        answer = client.post(act.address, {"from": "first", **act.fields})
        assert answer["Location"] == reverse("admin:index"), one
    assert pending(root).items == ()
    incident.refresh_from_db()
    program.refresh_from_db()
    assert incident.closed_at is not None
    assert program.approved


def test_a_find_waits_with_its_picture_until_a_moderator_has_decided(robot, people, entry):
    now = SYSTEM.now()
    find = finds.report(entry.turn, people["ada"], finds.Report("a spoon", entry.frame_id, 0.1, 0.4), now)
    log.moderate(entry, people["mod"], Visibility.PUBLISHED, "", now)
    mod = with_rights("mia", "change_find", "view_find")
    (item,) = pending(mod).items
    assert (item.kind, item.text, item.frame) == ("Find", "a spoon", entry.frame)
    assert item.since == now
    text = shown(mod)
    assert entry.frame.url in text
    assert "Picture of this find" in text
    client = signed_in(mod)
    assert "a spoon" in client.get(pending(mod).kinds[-1].url).content.decode()
    piece = find.round.pieces.first()
    answer = client.post(item.url, {"state": "confirmed", "piece": piece.pk, "_save": "Save"})
    assert answer.status_code == 302
    assert pending(mod).items == ()
    Find.objects.update(state="reported", piece=None)
    act = pending(mod).items[0].acts[0]
    assert client.post(act.address, {"from": "first", **act.fields})["Location"] == reverse("admin:index")
    assert Find.objects.get().state == "declined"
    assert pending(mod).items == ()
    Find.objects.update(state="reported")
    for other in (people["mod"], people["kim"], with_rights("looks", "view_find")):
        assert "a spoon" not in shown(other)


def test_each_kind_is_shown_to_those_who_may_decide_on_it(robot, people, entry, program):
    services.stop(robot, people["kim"])
    Incident.objects.create(robot=robot, at=SYSTEM.now(), code="x", text="Silent.")
    seen = {
        "mod": {"Entry"}, "kim": {"Robot", "Incident"},
        **{with_rights(code, code).username: kinds for code, kinds in
           (("change_program", {"Program"}), ("view_program", set()), ("view_entry", set()), ("view_incident", {"Incident"}))},
    }  # fmt: skip
    for name, kinds in seen.items():
        user = User.objects.get(username=name)
        assert {one.kind for one in pending(user).items} == kinds, name
        text = shown(user)
        assert ("A watch in the sand." in text) == ("Entry" in kinds)
        assert ("nod" in text) == ("Program" in kinds)
    assert pending(with_rights("looks", "view_incident")).items[0].acts == ()


def test_each_list_is_bounded_and_says_how_many_there_are(robot, people):
    now = SYSTEM.now()
    Incident.objects.bulk_create(
        Incident(robot=robot, at=now - timedelta(minutes=n), code="x", text=f"number {n}") for n in range(MOST + 5)
    )
    found = pending(people["kim"])
    assert len([one for one in found.items if one.kind == "Incident"]) == MOST
    assert "number 0" in found.items[-1].what
    kind = next(kind for kind in found.kinds if kind.name == "Incidents")
    assert (kind.count, kind.listed) == (MOST + 5, MOST)
    assert "(the newest 20 stand here)" in shown(people["kim"])
    assert "number 24" in signed_in(people["kim"]).get(kind.url).content.decode()


def test_a_program_waits_until_staff_decide_and_again_after_a_change(robot, people, program):
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    assert programs.approve(program, root, False), "declined"
    assert not programs.approve(program, root, False)
    assert not programs.to_approve().exists()
    programs.save(robot, people["ada"], "nod", "up", True, SYSTEM.now(), program.pk)
    assert list(programs.to_approve()) == [program]
    assert programs.approve(program, root, True)
    assert not programs.approve(program, root, True)
    assert not programs.to_approve().exists()


def test_an_entry_waits_until_a_moderator_has_looked_and_again_after_a_change(robot, people, entry):
    now = SYSTEM.now()
    log.moderate(entry, people["mod"], Visibility.PUBLISHED, "", now)
    assert not log.to_review().exists()
    log.edit(entry, people["ada"], "A clock.", entry.frame_id, now + timedelta(seconds=1))
    assert list(log.to_review()) == [entry]
    listed = signed_in(people["mod"]).get("/admin/operatorlog/entry/?waits=review").content.decode()
    assert "A clock." in listed
    log.moderate(Entry.objects.get(), people["mod"], Visibility.HIDDEN, "rude", now + timedelta(seconds=2))
    assert not log.to_review().exists()


def test_robots_come_first_in_the_menu_and_each_page_is_in_it(people):
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    text = shown(root, "/admin/")
    menu = text[text.index('aria-label="Menu"') :]
    addresses = re.findall(r'<th scope="row".*?<a href="([^"]+)"', menu, re.DOTALL)
    assert addresses[0] == "/admin/robots/robot/"
    assert {"/status/", "/log/", "/survey/results/", "/movie-of-the-day/"} <= set(addresses)
    assert len(addresses) == len(set(addresses))
    assert "/survey/results/" not in shown(with_rights("vic", "view_entry"), "/admin/")


def test_scripts_and_styles_stand_in_no_page_of_staff(robot, people, entry):
    for page in PAGES:
        text = shown(people["kim"], page)
        assert not re.search(r"<script(?![^>]*(src=|application/json))|\son\w+=|\sstyle=", text)


@pytest.mark.parametrize("zone", ["Pacific/Kiritimati", "Pacific/Pago_Pago"])
def test_today_begins_at_midnight_of_the_reader(robot, people, zone):
    """Neither zone has the midnight of UTC, nor of the other."""
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    midnight = SYSTEM.now().astimezone(ZoneInfo(zone)).replace(hour=0, minute=0, second=0, microsecond=0)
    for text, seconds in (("of today", 0), ("of yesterday", -1)):
        Incident.objects.create(robot=robot, at=midnight + timedelta(seconds=seconds), code="x", text=text)
    client = signed_in(root)
    client.cookies["zone"] = zone
    today = next(one for one in client.get("/admin/live/").context["today"] if "Incidents" in one["words"])
    assert today["number"] == 1
    listed = client.get(today["url"]).content.decode()
    assert "of today" in listed
    assert "of yesterday" not in listed


def test_above_the_cards_stands_what_waits(robot, people):
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    for page in PAGES:
        above = shown(root, page).split("<article")[0]
        assert "Nothing waits." in above
    for _ in range(2):
        Incident.objects.create(robot=robot, at=SYSTEM.now(), code="outage", text="The arm was silent.")
    for page in PAGES:
        above = shown(root, page).split("<article")[0]
        assert re.search(r'<a href="#pending">Waits for you:</a>\s*<span>Incidents <b>2</b></span>\s*</p>', above)
    assert "#pending" not in shown(with_rights("vic", "view_entry")), "there are no cards above the list"


def test_the_title_names_robots_to_those_who_see_them(robot, people):
    assert "<h1>All robots</h1>" in shown(people["kim"], "/admin/")
    text = shown(people["mod"], "/admin/")
    assert "<h1>Overview</h1>" in text
    assert "All robots" not in text
