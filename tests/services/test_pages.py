"""Every address by every kind of person: status, headers, no key, no scripts inline."""

import re
from datetime import timedelta

import pytest
from django.contrib.auth.models import Permission

from accounts.models import Question, User
from accounts.services import load_bank
from portal.keep.seeding import seed
from portal.web.classic.models import ClassicToken
from queueing import services as queue
from robots import bus
from robots.kit.arms.objects import objects_of
from robots.kit.clock import SYSTEM
from robots.kit.contract.tidying import LONGEST_S, Tidy
from robots.kit.drivers.tidying import MOVE_S
from robots.models import Command, Frame, Program, Robot
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]

PUBLIC = ["/", "/story/", "/status/", "/log/", "/robots/mercury/", "/robots/mercury/orientation/", "/accounts/login/", "/accounts/signup/", "/accounts/password/reset/", "/livez"]  # fmt: skip
SIGNED_IN = ["/me/", "/robots/mercury/clearance/"]
STAFF = ["/admin/", "/admin/robots/robot/", "/admin/robots/command/", "/admin/robots/incident/"]


@pytest.mark.parametrize("address", PUBLIC)
def test_public_pages_need_no_account(robot, client, address):
    answer = client.get(address)
    assert answer.status_code == 200
    policy = answer["Content-Security-Policy"]
    assert "unsafe" not in policy
    assert "default-src 'self'" in policy
    html = answer.content.decode()
    assert not re.search(r"<script(?![^>]*\bsrc=)(?![^>]*application/json)[^>]*>", html)
    assert " style=" not in html
    assert not re.search(r"\son[a-z]+=", html)


@pytest.mark.parametrize("address", SIGNED_IN)
def test_own_pages_ask_strangers_to_sign_in(robot, client, address):
    answer = client.get(address)
    assert answer.status_code == 302
    assert "/accounts/login/" in answer["Location"]


@pytest.mark.parametrize("address", STAFF)
@pytest.mark.parametrize("who", [None, "ada", "eve"])
def test_the_admin_is_for_staff(people, client, address, who):
    if who:
        client.force_login(people[who])
    assert client.get(address).status_code == 302


@pytest.mark.parametrize("verb", ["stop", "enable", "disable", "lock_out", "lift", "procedure", "test", "release", "maintenance", "resume_jobs"])  # fmt: skip
@pytest.mark.parametrize("who", [None, "ada", "mod"])
def test_admin_verbs_are_refused_to_everybody_else(robot, people, client, verb, who):
    if who:
        client.force_login(people[who])
    client.post(f"/admin/robots/robot/{robot.pk}/do/{verb}/", {"note": "x", "checked": "yes"})
    robot.refresh_from_db()
    assert robot.enabled
    assert not robot.stop_latched
    assert robot.cycle == "ready"


@pytest.mark.asvs("3.5.3")
def test_a_get_of_an_admin_verb_does_nothing(robot, people, client):
    client.force_login(people["kim"])
    client.get(f"/admin/robots/robot/{robot.pk}/do/stop/")
    robot.refresh_from_db()
    assert not robot.stop_latched


def test_staff_run_the_robot_from_its_page(robot, people, owned, client):
    client.force_login(people["kim"])
    page = client.get(f"/admin/robots/robot/{robot.pk}/change/")
    assert page.status_code == 200
    assert b"residual" in page.content
    assert client.get(f"/admin/robots/robot/{robot.pk}/status/").status_code == 200
    do = f"/admin/robots/robot/{robot.pk}/do/"
    client.post(do + "lock_out/", {"note": "cleaning"})
    robot.refresh_from_db()
    assert (robot.cycle, robot.stop_latched) == ("locked_out", True)
    client.post(do + "release/", {"checked": "yes"})
    client.post(do + "maintenance/")
    client.post(do + "procedure/", {"kind": "calibrate"})
    assert Command.objects.get().kind == "calibrate"
    client.post(do + "lift/")
    robot.refresh_from_db()
    assert robot.cycle == "handover"
    client.post(do + "disable/")
    robot.refresh_from_db()
    assert not robot.enabled


def test_an_admin_adds_a_robot_on_one_page(robot, people, client, admin_user, monkeypatch):
    monkeypatch.setattr(bus, "wake_probes", lambda: True)
    client.force_login(admin_user)
    data = {"name": "Second", "slug": "second", "driver": "mercury", "address": "sim:mercury", "clearance_required": "on", "records": "off"}  # fmt: skip
    bad = client.post("/admin/robots/robot/add/", data | {"driver": "nothere"})
    assert b"no driver named" in bad.content
    bad = client.post("/admin/robots/robot/add/", data | {"address": "http://x"})
    assert b"Use sim:NAME" in bad.content
    good = client.post("/admin/robots/robot/add/", data | {"_continue": "1"})
    assert good.status_code == 302
    page = client.get(good["Location"])
    assert b"questions for the clearance test came with its package" in page.content
    second = Robot.objects.get(slug="second")
    assert Question.objects.filter(robot=second).count() >= 15, "somebody can pass the test"

    def press(words):
        """Press a button of the page; return the page to which it leads."""
        shown = client.get(good["Location"]).content.decode()
        forms = re.findall(r'<form method="post" action="([^"]+)">(.*?)</form>', shown, re.DOTALL)
        action, inside = next(one for one in forms if f">{words}</button>" in one[1])
        answer = client.post(action, dict(re.findall(r'name="([^"]+)" value="([^"]*)"', inside)), follow=True)
        assert answer.redirect_chain[-1][0] == good["Location"], "one page"
        return answer.content.decode()

    assert "The connection is being tested" in press("Test connection")
    second.refresh_from_db()
    assert second.probe_asked_at is not None
    Robot.objects.filter(pk=second.pk).update(
        probe_asked_at=None, probe={"connection": "ok", "picture": "ok", "file": "frames/second/probe.jpg"}
    )
    assert '<img src="/media/frames/second/probe.jpg" alt="First picture">' in press("Switch on")
    second.refresh_from_db()
    assert second.enabled


def test_what_a_package_brings_is_loaded_once_and_nothing_is_said_of_what_it_lacks(robot, people, client, admin_user):
    client.force_login(admin_user)
    data = {"name": "Arm", "slug": "arm", "driver": "pa10", "address": "sim:pa10", "records": "off"}
    assert client.post("/admin/robots/robot/add/", data).status_code == 302
    arm = Robot.objects.get(slug="arm")
    brought = Program.objects.filter(robot=arm, approved=True, author=None).count()
    assert brought > 0
    assert client.post(f"/admin/robots/robot/{arm.pk}/change/", data).status_code == 302
    assert Program.objects.filter(robot=arm).count() == brought


def test_staff_load_what_a_package_brings_for_a_robot_that_was_added_before(robot, people, client, admin_user):
    Question.objects.filter(robot=robot).delete()
    client.force_login(admin_user)
    chosen = {"action": "load_brought", "_selected_action": [robot.pk]}
    looks = User.objects.create(username="looks", email="looks@example.org", is_staff=True)
    looks.user_permissions.add(Permission.objects.get(codename="view_robot"))
    client.force_login(looks)
    client.post("/admin/robots/robot/", chosen)
    assert not Question.objects.filter(robot=robot).exists(), "who may only look loads nothing"
    client.force_login(admin_user)
    page = client.post("/admin/robots/robot/", chosen, follow=True)
    assert b"questions for the clearance test came with its package" in page.content
    loaded = Question.objects.filter(robot=robot).count()
    assert loaded >= 15
    page = client.post("/admin/robots/robot/", chosen, follow=True)
    assert f"It has {loaded} questions".encode() in page.content
    assert Question.objects.filter(robot=robot).count() == loaded
    Robot.objects.filter(pk=robot.pk).update(driver="gone")
    page = client.post("/admin/robots/robot/", chosen, follow=True)
    assert b"install its package" in page.content


def test_unknown_addresses_say_so(robot, client):
    answer = client.get("/robots/nothing/")
    assert answer.status_code == 404
    assert b"There is nothing here" in answer.content


@pytest.mark.asvs("5.3.2")
@pytest.mark.parametrize("path", ["../secret_key", "..%2f..%2fsecret_key", "/etc/passwd", "x/../../secret_key"])
def test_media_serves_frames_only(robot, client, path):
    assert client.get(f"/media/frames/{path}").status_code == 404


def test_seeding_twice_changes_nothing(db):
    assert seed()
    assert seed() is None


def test_arms_of_a_demo_tidy_between_two_turns_in_a_time_that_staff_could_set(db):
    seed()
    arms = [robot for robot in Robot.objects.all() if robot.spec().capability(Tidy)]
    assert {robot.driver for robot in arms} == {"pa10", "puma"}
    for robot in arms:
        objects = [one for one in objects_of(robot.driver).objects.values() if not one.hangs]
        assert 20 * (len(objects) - 1) + MOVE_S <= robot.tidying_s() <= LONGEST_S
    assert all(robot.tidying_s() == 0 for robot in Robot.objects.exclude(pk__in=[arm.pk for arm in arms]))


def test_the_first_admin_signs_in_with_the_password_that_was_printed_and_needs_no_mail(db, client, mailoutbox):
    password = seed()
    answer = client.post("/accounts/login/?next=/admin/", {"login": "admin", "password": password})
    assert (answer.status_code, answer["Location"]) == (302, "/admin/")
    assert client.get("/admin/").status_code == 200
    assert mailoutbox == []


def test_classic_page_moves_nothing_by_get(robot, people, client, owned):
    Frame.objects.create(robot=robot, taken_at=SYSTEM.now(), file="frames/x.jpg", width=192, height=165, pose=[0, 0.42, 0, 0], joints=[0.9, 1.8, 0, 0])  # fmt: skip
    client.force_login(people["ada"])
    queue.join(robot, people["ada"], SYSTEM.now(), classic=True)
    queue.tick(SYSTEM.now())
    entered = client.get("/classic/mercury/")
    page = client.get(entered["Location"])
    assert b"It is your turn" in page.content
    assert page["Cache-Control"].count("no-store")
    assert page["Referrer-Policy"] == "same-origin"
    client.post(entered["Location"], {"do": "accept"})
    page = client.get(entered["Location"])
    assert b"You drive" in page.content
    for query in ("?do=up", "?large.x=5&large.y=350", "?small.x=5&small.y=180"):
        client.get(entered["Location"] + query)
    assert Command.objects.count() == 0
    gif = re.search(rb'src="(/classic/[^"]+\.gif)"', page.content)[1].decode()
    picture = client.get(gif)
    assert picture["Content-Type"] == "image/gif"
    assert picture.content[:6] in (b"GIF87a", b"GIF89a")


def test_classic_token_spent_moves_once(robot, people, client, owned, monkeypatch):
    from portal.web.classic import views

    monkeypatch.setattr(views, "WAIT_S", 0.0)
    client.force_login(people["ada"])
    drive(robot, people["ada"], SYSTEM.now(), classic=True)
    address = client.get("/classic/mercury/")["Location"]
    client.post(address, {"do": "down"})
    assert Command.objects.count() == 1
    for _ in range(3):
        answer = client.post(address, {"do": "down"}, follow=True)
        assert b"used before" in answer.content
    assert Command.objects.count() == 1
    fresh = client.get("/classic/mercury/")["Location"]
    other = type(client)()
    other.force_login(people["bob"])
    answer = other.post(fresh, {"do": "down"}, follow=True)
    assert Command.objects.count() == 1, "a shared address gives nobody the operator's rights"
    assert b"You drive" not in answer.content
    assert ClassicToken.objects.filter(user=people["ada"], spent_at=None).exists()
    anonymous = type(client)()
    assert anonymous.post(fresh, {"do": "down"})["Location"].startswith("/accounts/login/")


@pytest.mark.asvs("3.5.1")
def test_forms_want_a_csrf_token(robot, people):
    from django.test import Client

    client = Client(enforce_csrf_checks=True)
    client.force_login(people["ada"])
    answer = client.post("/classic/mercury/x/", {"do": "join"})
    assert answer.status_code == 403
    assert b"out of date" in answer.content


def test_no_answer_of_any_page_holds_the_key(robot, people, client):
    from accounts import services
    from accounts.models import Choice

    load_bank(robot)
    client.force_login(people["eve"])
    services.mark_read(people["eve"], robot, SYSTEM.now())
    html = client.get("/robots/mercury/clearance/").content.decode()
    rows = re.findall(r'<input type="radio"[^>]*value="(\d+)"([^>]*)>', html)
    right = {str(pk) for pk in Choice.objects.filter(correct=True).values_list("pk", flat=True)}
    marks = {pk: extra.strip() for pk, extra in rows}
    assert len({marks[pk] for pk in marks if pk in right} | {marks[pk] for pk in marks if pk not in right}) == 1


def test_sign_up_does_not_tell_who_has_an_account(robot, people, client):
    data = {"username": "newone", "email": "ada@example.org", "password1": "correct horse 42"}  # fmt: skip
    known = client.post("/accounts/signup/", data)
    other = type(client)().post("/accounts/signup/", data | {"email": "nobody@example.org", "username": "newtwo"})
    assert (known.status_code, known["Location"]) == (other.status_code, other["Location"])


def test_ending_a_turn_from_the_admin_is_for_staff(robot, people, owned, client):
    from django.contrib.auth.models import Permission

    from queueing.models import Turn

    for name in ("mod", "kim"):
        people[name].user_permissions.add(*Permission.objects.filter(codename__in=["view_turn", "view_ticket"]))
    turn = drive(robot, people["ada"], SYSTEM.now())
    data = {"action": "end", "_selected_action": [turn.pk]}
    client.force_login(people["mod"])
    client.post("/admin/queueing/turn/", data)
    assert Turn.objects.filter(ended_at=None).exists(), "a moderator of the log ends no turns"
    client.force_login(people["kim"])
    client.post("/admin/queueing/turn/", data)
    turn.refresh_from_db()
    assert turn.end_reason == "ended by staff"


def test_an_entry_is_hidden_from_the_admin_with_a_reason_only(robot, people, owned, client):
    from operatorlog.models import Entry

    turn = drive(robot, people["ada"], SYSTEM.now())
    entry = Entry.objects.create(turn=turn, author=people["ada"], robot=robot, text="x", written_at=SYSTEM.now())
    client.force_login(people["mod"])
    address = f"/admin/operatorlog/entry/{entry.pk}/change/"
    client.post(address, {"visibility": "hidden", "words": ""})
    entry.refresh_from_db()
    assert entry.visibility == "published"
    client.post(address, {"visibility": "hidden", "words": "not kind"})
    entry.refresh_from_db()
    assert (entry.visibility, entry.moderated_by) == ("hidden", people["mod"])


def test_the_landing_page_says_when_there_is_no_picture_of_a_robot(robot, client):
    assert "No picture yet" in client.get("/").content.decode()
    Frame.objects.create(robot=robot, file="frames/x.jpg", taken_at=SYSTEM.now(), stable=True, width=192, height=165)
    html = client.get("/").content.decode()
    assert "No picture yet" not in html
    assert 'camera saw last"' in html, "it may be old; the page's program marks it as live once it is"


@pytest.mark.parametrize("address", ["/", "/status/"])
def test_a_robot_whose_package_is_gone_takes_no_other_page_down(robot, client, address):
    type(robot).objects.create(slug="gone", name="Gone", driver="gone", address="sim:gone", enabled=True)
    html = client.get(address).content.decode()
    assert "Gone" in html
    assert "No camera" not in html


@pytest.mark.parametrize("driver", ["gone", "so101"])
def test_the_page_of_a_robot_whose_package_is_gone_says_so(robot, client, driver):
    type(robot).objects.create(slug="lost", name="Lost one", driver=driver, address=f"sim:{driver}", enabled=True)
    answer = client.get("/robots/lost/")
    if driver == "so101" and answer.status_code == 200:
        return  # LeRobot is installed here
    assert answer.status_code == 503
    assert b"Lost one cannot be shown now" in answer.content
    assert client.get("/robots/lost/model.urdf").status_code == 404


def test_a_stored_picture_that_a_cache_has_is_not_sent_again(db, client, settings, tmp_path):
    settings.MEDIA_ROOT = tmp_path
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "a.jpg").write_bytes(b"picture")
    shown = client.get("/media/frames/a.jpg")
    assert (shown.status_code, shown.content) == (200, b"picture")
    again = client.get("/media/frames/a.jpg", headers={"If-None-Match": shown["ETag"]})
    assert (again.status_code, again.content, again["ETag"]) == (304, b"", shown["ETag"])
    assert again["Cache-Control"] == shown["Cache-Control"]
    assert client.get("/media/frames/a.jpg", headers={"If-Modified-Since": shown["Last-Modified"]}).status_code == 304
    assert client.get("/media/frames/a.jpg", headers={"If-None-Match": '"another"'}).status_code == 200


def test_a_test_of_the_connection_shows_that_it_runs_and_one_that_died_offers_again(client, robot, people):
    client.force_login(people["kim"])
    page, now = f"/admin/robots/robot/{robot.pk}/change/", SYSTEM.now()
    refresh = '<noscript><meta http-equiv="refresh"'
    for begun, words, runs in ((None, "waits for the tests before it", True), (now, "running since", True),
                               (now - timedelta(minutes=5), "test the connection again", False)):  # fmt: skip
        Robot.objects.update(probe_asked_at=now - timedelta(minutes=5), probe_begun_at=begun)
        told = client.get(page).content.decode()
        assert words in told and ("<progress" in told, refresh in told) == (runs, runs), words
