"""A text as long as its field allows is taken: a browser counts a line break once, and sends two characters for it.

Browsers count units of UTF-16, and the server characters, of which there are never more.
"""

import json
import re
from pathlib import Path

import pytest
from django.apps import apps
from django.db.models import TextField
from hypothesis import given
from hypothesis import strategies as st

from operatorlog import services as log
from operatorlog.models import Appeal, Entry, SurveyAnswer, SurveyQuestion, Visibility
from operatorlog.moderation import LONGEST_APPEAL
from operatorlog.services import LONGEST, LONGEST_ANSWER
from portal.folders import ROOT
from queueing import services as queue
from queueing.models import Job
from robots.kit.clock import SYSTEM
from robots.kit.plain import plain_breaks
from robots.models import Program, Robot
from robots.services.programs import LONGEST as LONGEST_PROGRAM
from robots.states import GrantEnd
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def lines(characters):
    """Return a text of so many characters for a browser, and what a form sends of it."""
    text = "a\n" * (characters // 2 - 1) + "bb"
    assert len(text) == characters
    return text, text.replace("\n", "\r\n")


def emoji(characters):
    """Return a text of so many units of UTF-16; and it again, for nothing in it is sent in another way."""
    text = "\N{WATCH}\ufe0f" + "\U0001f916" * (characters // 2 - 1)
    assert len(text.encode("utf-16-le")) // 2 == characters
    return text, text


each_text = pytest.mark.parametrize("full", [lines, emoji])


@pytest.fixture
def ended(robot, people, owned, client):
    """A turn of ada's that has ended; she is signed in."""
    now = SYSTEM.now()
    turn = drive(robot, people["ada"], now)
    queue.end_turn(turn, GrantEnd.HOLDER, "ended by the operator", now)
    client.force_login(people["ada"])
    return turn


@each_text
def test_an_entry_and_its_correction(ended, client, full):
    text, sent = full(LONGEST)
    assert client.post(ended.get_absolute_url(), {"text": sent}).status_code == 302
    assert Entry.objects.get().text == text
    changed = f"c{sent[1:]}"
    assert client.post(ended.get_absolute_url(), {"text": changed}).status_code == 302
    assert Entry.objects.get().text == f"c{text[1:]}"


@each_text
def test_an_appeal(ended, people, admin_user, client, full):
    ended.refresh_from_db()
    entry = log.write(ended, people["ada"], "A watch.", None, SYSTEM.now())
    log.moderate(entry, admin_user, Visibility.HIDDEN, "It is unkind.", SYSTEM.now())
    text, sent = full(LONGEST_APPEAL)
    assert client.post(ended.get_absolute_url(), {"appeal": sent}).status_code == 302
    assert Appeal.objects.get().words == text


def test_one_more_is_refused_with_what_was_counted_and_nothing_is_lost(ended, client):
    answer = client.post(ended.get_absolute_url(), {"text": lines(LONGEST)[1] + "b"})
    assert answer.status_code == 422
    assert f"yours has {LONGEST + 1}" in answer.content.decode()
    assert answer.context["text"] == lines(LONGEST)[0] + "b"


@pytest.fixture
def question(db):
    return SurveyQuestion.objects.create(prompt="What else?", kind="text")


@each_text
def test_an_answer_after_a_turn(ended, client, question, full):
    text, sent = full(LONGEST_ANSWER)
    assert client.post(ended.get_absolute_url(), {f"s{question.pk}": sent}).status_code == 302
    assert SurveyAnswer.objects.get().value == text


@each_text
def test_an_answer_after_a_job(shuttle, client, question, full):
    text, sent = full(LONGEST_ANSWER)
    client.post("/robots/mercury/jobs/", {"kind": "go", "arg-x": "1"})
    Job.objects.update(state="done", ended_at=SYSTEM.now())
    address = Job.objects.get().get_absolute_url()
    assert client.post(address, {"do": "survey", f"s{question.pk}": sent}).status_code == 302
    assert SurveyAnswer.objects.get().value == text


@pytest.mark.parametrize("full", [lines, emoji, lambda longest: ("\U0001f916" * longest,) * 2])
def test_a_program(robot, people, client, full):
    text, sent = full(LONGEST_PROGRAM)
    client.force_login(people["ada"])
    body = json.dumps({"name": "full", "text": sent}, ensure_ascii=False).encode()  # as JSON.stringify does
    assert client.post("/robots/mercury/programs/", body, content_type="application/json").status_code == 200
    assert Program.objects.get().text == text


def test_the_cameras_of_a_robot_in_the_admin(robot, client, admin_user):
    client.force_login(admin_user)
    text = "\n".join(f"http://cam.example.org/{number}.jpg?{'x' * 400}" for number in range(2))
    text += f"\nhttp://cam.example.org/{'y' * (1000 - len(text) - 24)}"
    assert len(text) == 1000
    data = {"name": "Second", "slug": "second", "driver": "mercury", "address": "sim:mercury", "records": "off"}
    answer = client.post("/admin/robots/robot/add/", data | {"camera": text.replace("\n", "\r\n")})
    assert answer.status_code == 302
    assert Robot.objects.get(slug="second").camera == text


BY_THE_ROBOT = {
    "program-text": None,
    "task-text": None,
    "hall-rules-text": None,
}  # its language refuses what is too long, in words


def test_each_field_of_several_lines_that_has_a_limit_is_tested_above():
    """Whoever adds one adds its test here."""
    stored = {
        f"{model._meta.label}.{field.name}"
        for model in apps.get_models()
        for field in model._meta.fields
        if type(field) is TextField and field.max_length
    }
    assert stored == {
        "operatorlog.Entry.text", "operatorlog.SurveyAnswer.value", "robots.Program.text", "robots.Robot.camera",
        "operatorlog.Decision.text",  # of the entry, as it was read
    }  # fmt: skip
    shown = {}
    for folder in ("templates", "robots"):
        for path in sorted(Path(ROOT, folder).rglob("*.html")):
            for tag in re.findall(r"<textarea[^>]*", path.read_text()):
                shown[re.search(r'id="([^"]+)"', tag)[1]] = re.search(r'maxlength="(\d+)"', tag)
    limits = {name: found and int(found[1]) for name, found in shown.items()}
    ours = {"text": LONGEST, "s{{ q.pk }}": LONGEST_ANSWER, "why-again": LONGEST_APPEAL}
    assert limits == {**ours, "lost": None, "lost-appeal": None, **BY_THE_ROBOT}


@given(st.text(alphabet="a\r\n\U0001f916", max_size=30))
def test_what_is_kept_has_one_kind_of_break_and_never_more_characters_than_a_browser_counts(text):
    plain = plain_breaks(text)
    assert "\r" not in plain
    assert plain_breaks(plain) == plain
    typed = text.replace("\r", "\n")  # as a field holds it
    assert plain_breaks(typed.replace("\n", "\r\n")) == typed
    assert len(plain) <= len(plain.encode("utf-16-le")) // 2
