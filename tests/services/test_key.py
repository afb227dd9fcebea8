"""Promise 20: what the server says does not depend on the key of the test until it is graded.

Two keys, the same bank otherwise; everything that can be reached is fetched under both. A page
that differs has told something of the key.
"""

import json
import random
import re
from html import unescape
from urllib.parse import urljoin, urlsplit

import pytest
from django.contrib.auth.models import AnonymousUser
from django.core.cache import cache
from django.db import transaction
from django.test import Client

from accounts import services
from accounts.models import Attempt, Choice, Question
from accounts.services import load_bank
from portal.live.snapshot import snapshot
from robots.kit.clock import SYSTEM
from tests.proof import Proof

pytestmark = pytest.mark.django_db
LINK = re.compile(r"""(?:href|src|action|hx-get|data-[\w-]+)="([^"#]+)""")
FRESH = re.compile(
    r'(csrfmiddlewaretoken" value="|csrf-token" content="|name="once" value="|nonce=")[^"]+'
)  # new at each request
TOKEN = re.compile(r"(/classic/mercury/)[^/\"]+")  # so is this: each page of the classic console has its own
TEST = "/robots/mercury/clearance/"


def plain(text: str) -> str:
    """Return the text without what is new at each request."""
    return TOKEN.sub(r"\1token", FRESH.sub("", text))


def crawl(client: Client) -> dict[str, str]:
    """Return what each address within reach of `client` says."""
    said, todo = {}, ["/", TEST, "/robots/mercury/orientation/", "/me/", "/readyz", "/accounts/login/"]
    while todo:
        path = todo.pop()
        if plain(path) in said or path.startswith(("/static/", "/accounts/logout")) or len(said) > 300:
            continue
        answer = client.get(path)
        body = b"".join(answer.streaming_content) if answer.streaming else answer.content
        text = body.decode(errors="replace")
        said[plain(path)] = plain(f"{answer.status_code} {answer.headers.get('Location', '')}\n{text}")
        for found in [answer.headers.get("Location", ""), *LINK.findall(text)]:
            link = urlsplit(urljoin(f"http://testserver{path}", unescape(found)))
            if found and link.netloc == "testserver" and link.scheme == "http":
                todo.append(link.path + (f"?{link.query}" if link.query else ""))
    return said


def everything(client: Client, robot, person, answers: dict[str, int] | None) -> dict[str, str]:
    """Return everything that the server answers to `person`, who may send the test first."""
    said = {}
    if answers:
        sent = client.post(TEST, answers, follow=True)
        said["sent"] = plain(f"{sent.status_code} {sent.content.decode()}")
    said |= crawl(client)
    shown = snapshot(robot.slug, person or AnonymousUser(), SYSTEM.now(), True)
    said["socket"] = json.dumps(shown, default=str)
    return said


def under(key: int, robot, person, answers):
    """Return all that is said where each question's answer number `key` is the right one; nothing stays."""
    cache.clear()
    client = Client()
    with transaction.atomic():
        point = transaction.savepoint()
        if person is not None:
            client.force_login(person)
        for question in Question.objects.filter(robot=robot):
            for number, choice in enumerate(Choice.objects.filter(question=question).order_by("pk")):
                Choice.objects.filter(pk=choice.pk).update(correct=number == key)
        said = everything(client, robot, person, answers)
        transaction.savepoint_rollback(point)
    return said


def third(attempt: Attempt) -> dict[str, int]:
    """Return answers that are wrong under both keys."""
    return {"attempt": attempt.pk} | {f"q{q.id}": sorted(pk for pk, _ in q.choices)[2] for q in services.questions(attempt)}  # fmt: skip


@pytest.mark.asvs("15.3.1")
@pytest.mark.parametrize("who", ["nobody", "reader", "asked", "incomplete", "failed", "cleared"])
def test_promise_20_the_key_never_leaves_the_server(robot, people, who, monkeypatch):
    now = SYSTEM.now()
    monkeypatch.setattr(type(SYSTEM), "now", lambda _: now)  # the same moment for both
    load_bank(robot)
    person = {"nobody": None, "cleared": people["ada"]}.get(who, people["eve"])
    answers = None
    if who in ("asked", "incomplete", "failed"):
        services.mark_read(person, robot, SYSTEM.now())
        answers = third(services.begin(person, robot, SYSTEM.now()))
    if who == "asked":
        answers = None
    if who == "incomplete":
        answers = dict(list(answers.items())[:-1])
    seen = []
    for key in (0, 1):
        monkeypatch.setattr(services, "_random", random.Random(7))  # the same questions for both
        seen.append(under(key, robot, person, answers))
    first, second = seen
    assert first.keys() == second.keys()
    assert {path: (first[path], second[path]) for path in first if first[path] != second[path]} == {}
    if who == "asked":
        assert "</form>" in first[TEST], "the test was among what was fetched"
        assert all(q.text in unescape(first[TEST]) for q in services.questions(Attempt.objects.get()))
    proof = Proof(f"test_key.py::test_promise_20_the_key_never_leaves_the_server[{who}]", 20)
    proof.count("kinds of visitor", 1, 1)
    proof.holds(f"{who}: {len(first)} addresses say the same under two keys")
