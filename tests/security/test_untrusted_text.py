"""What strangers, staff and robots wrote is shown as text, never as markup; errors tell nothing of the inside."""

from html.parser import HTMLParser

import pytest
from markdown_it import MarkdownIt

from operatorlog.models import Entry
from queueing import services as queue
from queueing.models import Turn
from robots.kit import description
from robots.kit.clock import SYSTEM
from robots.models import Incident, Robot
from robots.states import GrantEnd
from tests.services.turns import drive

pytestmark = pytest.mark.django_db
CORPUS = [
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "'><svg/onload=alert(1)>",
    "</title></textarea></script><script>alert(1)</script>",
    "javascript:alert(1)",
    "{{ 7|add:7000001 }}{% debug %}",
    "<iframe srcdoc='<script>alert(1)</script>'>",
    "</script><!--<script>",
]


class Elements(HTMLParser):
    """Collect what a browser would run or load."""

    def __init__(self) -> None:
        super().__init__()
        self.bad: list[str] = []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if tag == "iframe" or (tag == "script" and "src" not in given and given.get("type") != "application/json"):
            self.bad.append(tag)
        self.bad += [f"{tag} {name}" for name in given if name.startswith("on") or name == "style"]
        for name in ("href", "src", "action", "formaction"):
            if (given.get(name) or "").strip().lower().startswith(("javascript:", "data:text")):
                self.bad.append(f"{tag} {name}={given[name]}")


@pytest.mark.asvs("3.4.3")
@pytest.mark.asvs("1.2.1", "1.1.2", "3.2.2", "1.3.7", "1.3.10")
@pytest.mark.parametrize("text", CORPUS)
def test_promise_41_text_is_text_on_every_page(robot, people, owned, client, text):
    now = SYSTEM.now()
    turn = drive(robot, people["ada"], now)
    queue.end_turn(turn, GrantEnd.STAFF, text[:120], now)
    entry = Entry.objects.create(turn=turn, author=people["ada"], robot=robot, text=text, written_at=now)
    Incident.objects.create(robot=robot, at=now, code="fault", text=text)
    Robot.objects.filter(pk=robot.pk).update(
        name=text[:80], tagline=text, story=text, reason=text[:300], lockout_note=text, probe={"connection": text}
    )
    people["ada"].__class__.objects.filter(pk=people["ada"].pk).update(username=text[:30])
    root = people["ada"].__class__.objects.create_superuser("root", "root@example.org", "correct horse 42")
    client.force_login(root)
    admin = f"/admin/robots/robot/{robot.pk}"
    pages = ["/", "/story/", "/status/", "/log/", "/robots/mercury/", "/robots/mercury/orientation/", "/me/",
             f"/turns/{turn.pk}/", f"{admin}/change/", f"{admin}/status/", f"/admin/operatorlog/entry/{entry.pk}/change/",
             "/admin/robots/incident/", "/admin/queueing/turn/"]  # fmt: skip
    for page in pages:
        answer = client.get(page)
        assert answer.status_code == 200, page
        html = answer.content.decode()
        found = Elements()
        found.feed(html)
        assert found.bad == [], page
        assert "7000008" not in html, page
        assert "unsafe" not in answer["Content-Security-Policy"], page


@pytest.mark.asvs("1.2.1", "3.4.3")
@pytest.mark.asvs("1.3.5")
@pytest.mark.parametrize("text", [*CORPUS, "[a](javascript:alert(1))", "![a](data:text/html;base64,AAAA)"])
def test_markdown_brings_no_markup_of_its_own(text):
    found = Elements()
    found.feed(MarkdownIt("commonmark", {"html": False}).render(text))
    assert found.bad == []


@pytest.mark.asvs("16.5.1", "16.5.3")
def test_an_unexpected_error_says_nothing_of_the_inside(robot, client, monkeypatch):
    def broken(*_):
        raise RuntimeError("secret-inside /srv/private")

    monkeypatch.setattr(Robot, "description", broken)
    monkeypatch.setattr(description, "load", broken)
    client.raise_request_exception = False
    answer = client.get("/robots/mercury/")
    assert answer.status_code == 500
    html = answer.content.decode()
    for word in ("secret-inside", "Traceback", "RuntimeError", ".py"):
        assert word not in html
    assert Turn.objects.count() == 0


@pytest.mark.asvs("3.5.1", "3.5.3", "8.3.1")
@pytest.mark.parametrize("origin", ["https://elsewhere.example", "null", "http://localhost.elsewhere.example"])
def test_a_form_from_another_site_changes_nothing(robot, people, origin):
    from django.test import Client

    client = Client(enforce_csrf_checks=True)
    client.force_login(people["ada"])
    token = "a" * 32
    client.cookies["csrftoken"] = token
    for path in ("/robots/mercury/orientation/", "/accounts/logout/", "/robots/mercury/programs/"):
        answer = client.post(path, {"csrfmiddlewaretoken": token}, headers={"origin": origin})
        assert answer.status_code == 403, path
    assert client.get("/me/").status_code == 200
