"""A simulated robot is marked as simulated wherever it is shown; nobody is told its address."""

import json
import re

import pytest
from django.conf import settings
from django.contrib.auth.models import AnonymousUser
from django.core import mail
from django.template.loader import get_template

from operatorlog import services as log
from portal.live.snapshot import snapshot
from portal.live.standing import places
from queueing import services as queue
from queueing.jobs import running
from queueing.models import Job, Turn
from queueing.services import Asker, ask, standings
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.states import GrantEnd

pytestmark = pytest.mark.django_db
BADGE = re.compile(r'<span class="simulated">Simulated</span>')
PAGES = {
    "landing": "/", "robot": "/robots/mercury/", "status": "/status/", "log": "/log/", "orientation": "/robots/mercury/orientation/",
    "clearance": "/robots/mercury/clearance/", "recordings": "/robots/mercury/recordings/", "me": "/me/",
    "jobs": "/robots/mercury/jobs/",
}  # fmt: skip
SIM, REAL = "sim:mercury", "serial:/dev/ttyUSB0"


@pytest.fixture
def told(robot, roles):
    """An ended turn with an entry."""
    turn = Turn.objects.get()
    queue.end_turn(turn, GrantEnd.FINISHED, "", SYSTEM.now())
    turn.refresh_from_db()
    log.write(turn, roles["operator"], "I found a ring", None, SYSTEM.now())
    return turn


def shown(client, path):
    answer = client.get(path, follow=True)
    assert answer.status_code in (200, 404), path
    page = answer.content.decode()
    return bool(BADGE.search(page)), page


@pytest.mark.parametrize("address", [SIM, REAL])
@pytest.mark.parametrize("where", [*PAGES, "turn", "classic"])
def test_every_page_of_a_simulated_robot_says_so_and_no_page_of_another(robot, roles, told, client, where, address):
    Robot.objects.update(address=address)
    if where in ("me", "clearance"):
        client.force_login(roles["operator"])
    path = {"turn": told.get_absolute_url(), "classic": "/classic/mercury/"}.get(where) or PAGES[where]
    said, page = shown(client, path)
    assert said is (address == SIM), path
    assert address not in page
    assert not re.search(r"\breal (robot|arm)s?\b", page, re.IGNORECASE), "no text says more than it knows"


def test_what_other_software_reads_says_so(robot, roles, client):
    for address in (SIM, REAL):
        Robot.objects.update(address=address)
        told = snapshot("mercury", AnonymousUser(), SYSTEM.now(), True)
        assert told["robot"]["simulated"] is (address == SIM)
        assert address not in json.dumps(told, default=str)
        place = places(standings(roles["operator"], SYSTEM.now()), SYSTEM.now())["places"][0]
        assert (place["name"], place["simulated"]) == ("Mercury", address == SIM)
        client.force_login(roles["operator"])
        bar = client.get("/story/").content.decode().partition('id="turnbar"')[2]
        assert bool(BADGE.search(bar)) is (address == SIM)


def test_mails_and_the_admin_say_so(robot, people, shuttle, client, admin_user, django_capture_on_commit_callbacks):
    job = ask(shuttle, Asker(people["ada"]), "go", {"x": 1.0}, SYSTEM.now(), mail=True)
    with django_capture_on_commit_callbacks(execute=True):
        running.end(job.queue, Job.objects.get(), "cancelled", "Cancelled.", 0.0, SYSTEM.now())
    assert mail.outbox[0].subject == "Your job on Mercury (simulated) has ended"
    client.force_login(people["ada"])
    assert shown(client, job.get_absolute_url())[0]
    assert shown(client, "/robots/mercury/jobs/")[0]
    assert shown(client, "/robots/mercury/statistics/")[0]
    assert client.get("/robots/mercury/statistics.json").json()["simulated"] is True
    client.force_login(admin_user)
    listed = client.get("/admin/robots/robot/").content.decode()
    assert 'class="field-simulated"' in listed


def test_templates_that_show_a_robot_by_its_heading_show_the_badge():
    """A page that is added later says it too."""
    wrong = []
    for path in (settings.BASE_DIR / "templates").rglob("*.html"):
        text = path.read_text()
        for heading in re.findall(r"<h1>.*?</h1>", text):
            if "robot.name" in heading and "simulated.html" not in heading and path.name not in ("robot.html",):
                wrong.append(str(path))
    assert wrong == []
    assert get_template("simulated.html").render({"robot": Robot(address="sim:mercury")}).count("Simulated") == 1
