"""Checks at saving, pages that no cache keeps, and settings that a public portal refuses."""

import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from django.db import connection

from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.models import Program
from robots.services import programs
from tests import starts
from tests.environment import ROOT
from tests.waiting import CEILING_S

pytestmark = pytest.mark.django_db


@pytest.mark.service
@pytest.mark.asvs("2.3.2", "2.3.4")
@pytest.mark.django_db(transaction=True)
def test_fifty_programs_are_fifty(robot, people):
    ada, together = people["ada"], threading.Barrier(10)
    Program.objects.bulk_create(
        Program(robot=robot, author=ada, name=f"p{n}", text="x", changed_at=SYSTEM.now())
        for n in range(programs.MOST - 3)
    )

    def save(number):
        together.wait(CEILING_S)
        try:
            programs.save(robot, ada, f"new {number}", "x", False, SYSTEM.now())
        except NotPermitted:
            return 0
        finally:
            connection.close()
        return 1

    with ThreadPoolExecutor(10) as pool:
        saved = sum(pool.map(save, range(10)))
    assert (saved, Program.objects.filter(author=ada).count()) == (3, programs.MOST)


GOOD = {
    "name": "Second",
    "slug": "second",
    "driver": "mercury",
    "address": "sim:mercury",
    "records": "off",
}


@pytest.mark.service
@pytest.mark.asvs("1.3.6", "15.3.2")
@pytest.mark.parametrize("field, value", [
    ("address", "serial:/dev/../etc/passwd"), ("address", "tcp:169.254.169.254:80"), ("address", "file:///etc/passwd"),
    ("camera", "http://169.254.169.254/latest"), ("camera", "file:///etc/passwd"),
    ("microphone", "http://169.254.169.254/a.wav"), ("microphone", "alsa:file:/etc/passwd"), ("turn_s", "0"), ("turn_s", "5"), ("turn_s", "99999999"),
])  # fmt: skip
def test_a_robot_that_cannot_be_is_not_saved(robot, client, admin_user, field, value):
    client.force_login(admin_user)
    answer = client.post("/admin/robots/robot/add/", GOOD | {field: value})
    assert answer.status_code == 200
    assert b"errorlist" in answer.content
    assert type(robot).objects.count() == 1


@pytest.mark.service
def test_a_robot_that_can_be_is_saved(robot, client, admin_user):
    client.force_login(admin_user)
    more = {
        "address": "tcp:arm.example.org:8101",
        "camera": "http://cam.example.org/a.jpg",
        "microphone": "alsa:hw:1,0",
        "turn_s": "60",
    }
    assert client.post("/admin/robots/robot/add/", GOOD | more).status_code == 302


@pytest.mark.service
@pytest.mark.parametrize("driver, turns", [("mercury", True), ("irat", False), ("gone", True)])
def test_the_length_of_turns_is_set_where_a_robot_has_commands_for_them(robot, client, admin_user, driver, turns):
    type(robot).objects.filter(pk=robot.pk).update(driver=driver)
    client.force_login(admin_user)
    page = client.get(f"/admin/robots/robot/{robot.pk}/change/")
    assert page.status_code == 200
    assert (b'name="turn_s"' in page.content) == turns


@pytest.mark.asvs("14.3.2")
@pytest.mark.parametrize("address", [
    "/", "/log/", "/me/", "/robots/mercury/", "/robots/mercury/orientation/", "/robots/mercury/clearance/", "/turns/{}/",
    "/admin/", "/admin/robots/robot/", "/accounts/email/", "/accounts/password/change/", "/accounts/reauthenticate/",
])  # fmt: skip
def test_what_is_drawn_for_a_person_is_kept_by_no_cache(roles, client, address):
    from queueing.models import Turn

    client.force_login(roles["superuser" if "admin" in address else "operator"])
    answer = client.get(address.format(Turn.objects.get().pk))
    assert "no-store" in answer["Cache-Control"]
    assert "private" in answer["Cache-Control"]


def test_pages_for_everybody_may_be_kept(robot, client):
    assert not client.get("/story/").has_header("Cache-Control")
    assert "public" in client.get("/robots/mercury/model.urdf").get("Cache-Control", "public")


@pytest.mark.parametrize("mail, status", [
    ("consolemail://", 1), pytest.param("dummymail://", 1, marks=pytest.mark.length), ("smtp://localhost:25", 0),
])  # fmt: skip
def test_a_public_portal_that_sends_no_mails_does_not_start(tmp_path, mail, status):
    env = {
        **os.environ, "FARHAND_VAR": str(tmp_path), "FARHAND_PUBLIC": "1", "ALLOWED_HOSTS": "robots.example.org",
        "EMAIL_URL": mail, "DATABASE_URL": "sqlite:///:memory:",
    }  # fmt: skip
    env.pop("DJANGO_ALLOW_ASYNC_UNSAFE", None)  # of the tests themselves
    done = subprocess.run([sys.executable, "manage.py", "check", "--deploy"], cwd=ROOT, env=env, capture_output=True, text=True)  # fmt: skip
    assert done.returncode == status, done.stderr
    assert ("has to send mails" in done.stderr) == bool(status)


SITES = [
    ({}, "http://localhost:8000"),
    ({"ALLOWED_HOSTS": "192.168.1.20"}, "http://192.168.1.20:8000"),
    ({"ALLOWED_HOSTS": ".example.org", "FARHAND_PUBLIC": "1"}, "https://example.org"),
    ({"CSRF_TRUSTED_ORIGINS": "https://*.example.org,https://b.example.org:444"}, "https://b.example.org:444"),
    ({"CSRF_TRUSTED_ORIGINS": "https://b.example.org", "FARHAND_URL": "https://c.example.org/"}, "https://c.example.org"),
    ({"FARHAND_URL": "robots.example.org"}, ""), ({"FARHAND_URL": "https://a.example.org/path"}, ""),
    ({"FARHAND_URL": "https://user@a.example.org"}, ""), ({"FARHAND_URL": "http://a.example.org", "FARHAND_PUBLIC": "1"}, ""),
]  # fmt: skip


def test_the_address_of_the_site_in_mails(tmp_path):
    names = ("ALLOWED_HOSTS", "CSRF_TRUSTED_ORIGINS", "FARHAND_URL", "FARHAND_PUBLIC")
    env = {k: v for k, v in os.environ.items() if k not in names} | {"FARHAND_VAR": str(tmp_path)}
    for (given, address), (value, error) in zip(
        SITES, starts.read("SITE_ADDRESS", [given for given, _ in SITES], env), strict=True
    ):
        assert value == address, given
        assert bool(address) or "FARHAND_URL" in error.splitlines()[-1], given
