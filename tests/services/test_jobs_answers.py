"""Jobs as a console requests them: JSON answers, one's own jobs, the order in which they are served, first settings."""

from dataclasses import replace
from datetime import timedelta

import pytest
from django.contrib.auth.models import AnonymousUser
from django.test import Client

from portal.keep.seeding import add_robot
from portal.live.snapshot import snapshot
from portal.web.composites.drawing import waiting_jobs
from queueing import services as queue
from queueing.models import Job, QueueRobot
from queueing.rows import BadSettings
from queueing.services import Asker, ask, forecast, in_order, queue_of
from robots.kit import description
from robots.kit.clock import SYSTEM, ms_of
from robots.models import Command, Robot
from tests.services.browsers import signed_in
from tests.services.test_jobs import settle

pytestmark = [pytest.mark.service, pytest.mark.django_db]
JSON = {"accept": "application/json"}
GUEST, OTHER = Asker(guest="a" * 64, network="192.0.2.1"), Asker(guest="b" * 64, network="192.0.2.2")
SAME = Asker(guest="c" * 64, network="192.0.2.1")


def post(client, x="1.0", **more):
    return client.post("/robots/mercury/jobs/", {"kind": "go", "arg-x": x}, headers=JSON, **more)


def own(client):
    return client.get("/robots/mercury/jobs/", headers=JSON).json()["jobs"]


def test_a_script_asks_lists_and_cancels_as_a_guest(shuttle):
    guest, other = Client(), Client()
    answer = post(guest)
    job = Job.objects.get()
    assert (answer.status_code, answer.json()["url"], answer.json()["state"]) == (201, f"/jobs/{job.key}/", "waiting")
    assert "Accept" in answer["Vary"]
    assert [one["id"] for one in own(guest)] == [job.pk]
    assert own(other) == []
    again = post(guest)
    assert (again.status_code, "open job" in again.json()["error"]) == (429, True)
    assert other.post(job.get_absolute_url(), headers=JSON).status_code == 403
    done = guest.post(job.get_absolute_url(), headers=JSON)
    assert (done.status_code, done.json()["state"], own(guest)[0]["open"]) == (200, "cancelled", False)


@pytest.mark.parametrize("x", ["", "nan", "inf", "1e308", "-1", "two", "9" * 400])
def test_a_wrong_value_is_one_sentence(shuttle, x):
    answer = post(Client(), x)
    assert (answer.status_code, Job.objects.count()) == (400, 0)
    assert answer.json()["error"].endswith(".")


def test_a_form_without_the_token_is_refused(shuttle):
    assert post(Client(enforce_csrf_checks=True)).status_code == 403


def test_what_ended_long_ago_is_not_listed(shuttle, clock):
    guest = Client()
    post(guest)
    Job.objects.update(state="done", ended_at=Job.objects.get().asked_at - timedelta(hours=2))
    assert own(guest) == []


def test_everybody_sees_the_order_in_which_jobs_are_served_and_nobody_their_addresses(shuttle, clock):
    first = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    behind = ask(shuttle, SAME, "go", {"x": 0.5}, clock.now())
    other = ask(shuttle, OTHER, "go", {"x": 2.0}, clock.now())
    queue.tick(clock.now())
    shown = snapshot("mercury", AnonymousUser(), clock.now(), True)
    assert [(j["id"], j["ahead"], j["state"]) for j in shown["jobs"]] == [
        (first.pk, 0, "running"), (other.pk, 1, "waiting"), (behind.pk, 2, "waiting"),
    ]  # fmt: skip
    assert [j["args"] for j in shown["jobs"]] == [{"x": 1.0}, {"x": 2.0}, {"x": 0.5}]
    assert shown["queue"] == 2
    assert first.key not in str(shown)
    assert [j["wait_s"] for j in shown["jobs"]] == [(0, 0), (0, 20), (0, 40)], "none has ended yet: the kind's limit"
    served = []
    for _ in range(3):
        served.append(Job.objects.get(state="running").pk)
        settle(clock)
    assert served == [first.pk, other.pk, behind.pk], "as it was foreseen"


def test_composites_number_jobs_as_the_robots_page_does(shuttle, clock):
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    for n, guest in enumerate("cde"):  # behind the first, without a tag
        ask(shuttle, replace(SAME, guest=guest * 64), "go", {"x": 1.1 + n / 10}, clock.now())
    ask(shuttle, OTHER, "go", {"x": 2.0}, clock.now())
    ask(shuttle, replace(OTHER, guest="f" * 64), "go", {"x": 1.9}, clock.now())
    queue.tick(clock.now())
    shown = snapshot("mercury", AnonymousUser(), clock.now(), True)["jobs"]
    assert waiting_jobs("mercury") == [job["args"] for job in shown]
    assert waiting_jobs("nobody") == []


def test_an_order_is_foreseen_where_the_package_of_the_robot_is_missing(shuttle, clock):
    QueueRobot.objects.update(charged_in="seconds")
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    Robot.objects.update(driver="none")
    assert in_order(Robot.objects.get()) == [job]


def test_the_wait_is_judged_by_the_jobs_before_and_unknown_while_nobody_knows(shuttle, clock):
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    settle(clock, seconds=8)
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    ask(shuttle, OTHER, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    low, high = forecast(shuttle, clock.now())[1].wait_s
    assert (low, high) == (8, 8)
    Robot.objects.update(cycle="fault")
    shuttle.refresh_from_db()
    assert forecast(shuttle, clock.now())[1].wait_s is None


@pytest.mark.parametrize(("share", "high"), [(0.5, 8), (0.999, 5), (None, 12), (-1, 12), (0, 12)])
def test_a_robot_that_tells_its_progress_is_believed(shuttle, clock, share, high):
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    ask(shuttle, OTHER, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    Command.objects.update(progress={"text": "", "share": share})
    assert forecast(shuttle, clock.go(8))[1].wait_s == (0, high)


def test_a_robot_that_takes_no_jobs_shows_none(robot, clock):
    assert snapshot("mercury", AnonymousUser(), clock.now(), True)["jobs"] == []


def test_a_new_robot_has_the_settings_of_its_folder_and_staff_change_them(shuttle, clock):
    added = add_robot("shuttle")
    link = QueueRobot.objects.get(robot=added)
    assert (link.offers_turns, link.guests_ask, link.charged_in, link.rest_after_min) == (False, True, "jobs", 15)
    QueueRobot.objects.filter(pk=link.pk).update(guests_ask=False)
    assert not QueueRobot.objects.get(queue=queue_of(added)).guests_ask


def test_a_robot_that_an_admin_added_has_its_queue_before_anybody_asks(shuttle, clock):
    added = Robot.objects.create(slug="second", name="S", driver="shuttle", address="sim:shuttle", enabled=True)
    queue.tick(clock.now())
    assert QueueRobot.objects.get(robot=added).guests_ask


@pytest.mark.parametrize("told", [{"no_such": 1}, {"charged_in": "eggs"}, {"rest_after_min": -1}, {"guests_ask": "x"}])
def test_wrong_settings_are_named_and_keep_no_other_robot_from_its_queue(shuttle, clock, monkeypatch, told):
    added = Robot.objects.create(slug="second", name="S", driver="shuttle", address="sim:shuttle", enabled=True)
    whole = description.load("shuttle")
    monkeypatch.setattr(description, "load", lambda driver: whole | {"queue": told})
    with pytest.raises(BadSettings, match="robot.toml of shuttle"):
        queue_of(added)
    queue.tick(clock.now())
    assert not QueueRobot.objects.filter(robot=added).exists()


def test_the_page_of_a_robot_that_nobody_drives_offers_no_turn_and_names_staffs_commands_to_staff_alone(
    shuttle, people
):
    stranger, kim = Client(), signed_in(people["kim"])
    page, theirs = (one.get("/robots/mercury/").content.decode() for one in (stranger, kim))
    assert "It works by itself" in page
    assert "Drive it yourself" not in page
    assert ('"kind": "roam"' in page, '"kind": "roam"' in theirs) == (False, True)


def test_the_command_of_a_job_stores_which_picture_its_asker_saw(shuttle, clock):
    ada, taken = Client(), SYSTEM.now() - timedelta(seconds=3)
    body = {"kind": "go", "arg-x": "1.0", "seen": str(ms_of(taken))}
    assert ada.post("/robots/mercury/jobs/", body, headers=JSON).status_code == 201
    queue.tick(clock.now())
    assert ms_of(Command.objects.get().seen_picture_at) == ms_of(taken)


@pytest.mark.parametrize("seen", ["", "0", "-5", "9" * 18, "9" * 400, "now", "\u0663"])
def test_a_time_at_which_no_picture_was_taken_is_no_reason_to_refuse_a_job(shuttle, clock, seen):
    body = {"kind": "go", "arg-x": "1.0", "seen": seen}
    assert Client().post("/robots/mercury/jobs/", body, headers=JSON).status_code == 201
    queue.tick(clock.now())
    assert Command.objects.get().seen_picture_at is None
