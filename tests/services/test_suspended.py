"""After a stop jobs and the robot's own behaviour wait for staff, and every page says so and offers to resume them."""

import pytest
from django.contrib.auth.models import AnonymousUser
from django.test import Client

from portal.live.snapshot import snapshot
from queueing import services as queue
from queueing.services import ask, resume
from robots import services
from robots.kit.packets import Changed
from robots.models import Command, Robot
from tests.services.test_jobs import GUEST

pytestmark = [pytest.mark.service, pytest.mark.django_db]
WORDS = b"Jobs and the robot's own behaviour wait until staff press Resume jobs"


@pytest.fixture
def browsers(people):
    """Clients of Kim, who is staff of robots, and of Ada."""
    found = {name: Client() for name in ("kim", "ada")}
    for name, client in found.items():
        client.force_login(people[name])
    return found


@pytest.fixture
def released(shuttle, people, clock):
    """The robot was stopped, and the stop is released."""
    services.stop(shuttle, people["kim"], clock.now())
    services.release_stop(shuttle, people["kim"], True)
    shuttle.refresh_from_db()
    return shuttle


def suspended(robot, clock):
    return snapshot(robot.slug, AnonymousUser(), clock.now(), True)["suspended"]


def test_the_snapshot_says_it_from_the_stop_until_staff_resume(shuttle, people, clock):
    assert suspended(shuttle, clock) is False
    services.stop(shuttle, people["kim"], clock.go(1))
    assert suspended(shuttle, clock) is True
    services.release_stop(shuttle, people["kim"], True)
    assert suspended(shuttle, clock) is True
    resume(shuttle, people["kim"], clock.go(1))
    assert suspended(shuttle, clock) is False


def test_a_robot_that_does_nothing_by_itself_has_nothing_to_resume(robot, people, clock):
    services.stop(robot, people["kim"], clock.now())
    services.release_stop(robot, people["kim"], True)
    assert suspended(robot, clock) is False


@pytest.mark.parametrize("change", ["stop", "resume", "lock_out", "lift", "disable"])
def test_watchers_are_told_when_it_changes(released, people, clock, monkeypatch, django_capture_on_commit_callbacks, change):  # fmt: skip
    told, kim = [], people["kim"]
    if change == "lift":
        services.lock_out(released, kim, "cleaning")
    monkeypatch.setattr("robots.bus.publishing.publish", lambda slug, event: told.append((slug, event)) or True)
    with django_capture_on_commit_callbacks(execute=True):
        {
            "stop": lambda: services.stop(released, kim),
            "resume": lambda: resume(released, kim, clock.go(1)),
            "lock_out": lambda: services.lock_out(released, kim, "cleaning"),
            "lift": lambda: services.lift_lock_out(released, kim),
            "disable": lambda: services.set_enabled(released, kim, False),
        }[change]()
    assert any(slug == released.slug and isinstance(event, Changed) for slug, event in told)


@pytest.mark.parametrize("closed", ["lock-out", "switch"])
def test_what_is_open_again_to_the_public_says_that_it_waits_for_staff(shuttle, people, clock, browsers, closed):
    kim = people["kim"]
    if closed == "lock-out":
        services.lock_out(shuttle, kim, "cleaning")
        services.lift_lock_out(shuttle, kim)
    else:
        services.set_enabled(shuttle, kim, False)
        services.set_enabled(shuttle, kim, True)
    assert suspended(shuttle, clock) is True
    for name in ("kim", "ada"):
        assert WORDS in browsers[name].get("/robots/mercury/").content


def card(page):
    """Return the part of the robot's page about it: its opening tag, and its content."""
    start = page.index(b'id="suspended"')
    return page[page.rindex(b"<section", 0, start) : page.index(b"</section>", start)]


def test_the_robots_page_shows_it_and_offers_staff_the_button(shuttle, people, clock, browsers):
    quiet = card(browsers["ada"].get("/robots/mercury/").content)
    assert b" hidden" in quiet.split(b">")[0]
    services.stop(shuttle, people["kim"], clock.now())
    services.release_stop(shuttle, people["kim"], True)
    for name, button in (("kim", True), ("ada", False)):
        shown = card(browsers[name].get("/robots/mercury/").content)
        assert b" hidden" not in shown.split(b">")[0]
        assert WORDS in shown
        assert (b"Resume jobs</button>" in shown) is button
    answer = browsers["kim"].post("/robots/mercury/jobs/", {"do": "resume", "back": "robot"})
    assert answer["Location"] == "/robots/mercury/"
    assert b" hidden" in card(browsers["ada"].get("/robots/mercury/").content).split(b">")[0]


def test_a_job_that_waits_says_it_instead_of_its_place(released, people, clock, browsers):
    job = ask(released, GUEST, "go", {"x": 1.0}, clock.now())
    for address in (job.get_absolute_url(), "/robots/mercury/jobs/"):
        page = browsers["ada"].get(address).content
        assert WORDS in page, address
        assert b"It is next" not in page
    resume(released, people["kim"], clock.go(1))
    page = browsers["ada"].get(job.get_absolute_url()).content
    assert WORDS not in page
    assert b"It is next" in page


def test_the_admin_says_it_beside_a_button_that_resumes(released, people, clock, browsers):
    kim, of_robot = browsers["kim"], f"/admin/robots/robot/{released.pk}/"
    ask(released, GUEST, "go", {"x": 1.0}, clock.now())
    status = kim.get(f"{of_robot}status/").content
    assert WORDS in status
    assert b"Resume jobs</button>" in kim.get(f"{of_robot}change/").content
    assert browsers["ada"].post(f"{of_robot}do/resume_jobs/").status_code == 302, "to the sign-in"
    queue.tick(clock.go(1))
    assert Command.objects.count() == 0
    answer = kim.post(f"{of_robot}do/resume_jobs/", follow=True)
    assert b"Jobs and the robot&#x27;s own behaviour go on." in answer.content
    assert b"Resume jobs</button>" not in answer.content
    queue.tick(clock.go(1))
    assert Command.objects.count() == 1


def test_the_admin_resumes_nothing_while_the_stop_is_latched(shuttle, people, clock, browsers):
    services.stop(shuttle, people["kim"], clock.now())
    answer = browsers["kim"].post(f"/admin/robots/robot/{shuttle.pk}/do/resume_jobs/", follow=True)
    assert b"Release the stop first" in answer.content
    assert Robot.objects.get().stop_latched
