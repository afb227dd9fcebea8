"""From the first page to the first motion within the limit of time, on each robot of the package."""

import re
from datetime import timedelta
from html import unescape
from itertools import product

import pytest
from django.core import mail
from django.core.cache import cache

from accounts import services
from accounts.models import Attempt, Question
from operatorlog.models import SurveyQuestion
from portal.keep.seeding import SURVEY
from robots.grants import start_grant
from robots.kit.clock import SYSTEM
from robots.kit.contract.capabilities import Idle
from robots.models import Lease, Robot
from robots.states import Cycle, GrantKind
from tests import keystrokes as model
from tests.environment import ROOT
from tests.services.test_log import ended, turn  # noqa: F401

pytestmark = [pytest.mark.service, pytest.mark.django_db]

ROBOTS = sorted(path.parent.name for path in ROOT.glob("robots/kit/drivers/*/orientation.md"))
DRAWN = 5
INLINE = re.compile(r"</?(?:a|b|code|em|span|strong)\b[^>]*>")
FOLDED = re.compile(r"(<details>\s*<summary>.*?</summary>).*?</details>", re.DOTALL)


def text_of(pattern, page):
    """Return the words that a part of a page shows; what is folded is not read."""
    found = re.search(pattern, page, re.DOTALL)[0]
    return unescape(re.sub(r"<[^>]+>", " ", INLINE.sub("", FOLDED.sub(r"\1", found))))


@pytest.fixture(params=product(ROBOTS, ("en", "de")), ids="-".join)
def reader(request, client, robot):
    """A robot, and somebody who reads its texts in a language."""
    driver, language = request.param
    client.cookies["django_language"] = language
    robot, _ = Robot.objects.get_or_create(
        driver=driver, defaults={"slug": driver, "name": driver.title(), "address": f"sim:{driver}", "enabled": True}
    )
    services.load_bank(robot)
    Robot.objects.update(cycle=Cycle.READY)
    later = SYSTEM.now() + timedelta(days=1)
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": later})
    robot.refresh_from_db()
    if robot.spec().all_of(Idle):  # it moves by itself while nobody waits
        start_grant(robot, GrantKind.IDLE, SYSTEM.now(), until=later)
    return robot, client


@pytest.mark.parametrize("language", ["en", "de"])
def test_the_survey_after_a_turn_is_within_its_limit(ended, people, client, language):  # noqa: F811
    for position, (prompt, kind, options, low, high) in enumerate(SURVEY):
        SurveyQuestion.objects.create(
            prompt=prompt, kind=kind, options="\n".join(options), low_label=low, high_label=high, position=position
        )
    client.cookies["django_language"] = language
    client.force_login(people["ada"])
    html = client.get(ended.get_absolute_url()).content.decode()
    read = "".join(re.findall(r'<fieldset><legend>.*?</fieldset>|<label for="s\d+">.*?</label>', html, re.DOTALL))
    assert len(re.findall(r"<legend>|<label for", read)) == len(SURVEY)
    texts = model.typing_s(model.ANSWER) * sum(kind == "text" for _, kind, *_ in SURVEY)
    presses = len(SURVEY) + 1  # and *Send*
    assert model.reading_s(text_of(".+", read)) + presses * model.PRESS_S + texts <= model.SURVEY_WITHIN_S


def presses_of(orientation, test):
    """Return how many links, buttons and choices are pressed up to the first motion."""
    answers = len(set(re.findall(r'type="radio" name="(q\d+)"', test)))
    read = orientation.count('<form method="post"><input')
    sends = 1 if 'name="then" value="take"' in test else 3  # else one joins, and then takes control
    return len(("drive", "sign up")) + read + answers + sends + len(("the motion",))


def longest_test(robot, user):
    """Open a test for somebody, of the questions of a robot that have the most words."""

    def words(question):
        return sum(len(text.split()) for text in (question.text, *(c.text for c in question.choices.all())))

    bank = sorted(Question.objects.filter(robot=robot), key=words, reverse=True)[:DRAWN]
    drawn = [[q.pk, [c.pk for c in q.choices.all()]] for q in bank]
    Attempt.objects.create(user=user, robot=robot, drawn=drawn, started_at=SYSTEM.now())


def test_the_first_motion_is_within_the_limit_on_each_robot(reader, people):
    robot, client = reader
    cache.clear()  # attempts of other tests do not count
    first = client.get("/").content.decode()
    sent = client.post(
        "/accounts/signup/", model.FIELDS | {"username": "newcomer", "email": "new@example.org"}, follow=True
    )
    letter = mail.outbox[-1].body.partition("http")[0]
    client.force_login(people["eve"])
    orientation = client.get(f"{robot.get_absolute_url()}orientation/").content.decode()
    services.mark_read(people["eve"], robot, SYSTEM.now())
    longest_test(robot, people["eve"])
    test = client.get(f"{robot.get_absolute_url()}clearance/").content.decode()
    read = {
        "first": text_of(r'<div class="pitch">.*?</div>', first),
        "sent": text_of(r"(?<=</h1>)\s*<p>.*?</p>", sent.content.decode()),
        "mail": letter,
        "orientation": text_of(r"<article.*?</article>", orientation),
        "test": text_of(r'<form method="post" class="form">.*?</form>', test),
    }
    presses = presses_of(orientation, test)
    assert presses <= model.PRESSES
    words = {name: len(text.split()) for name, text in read.items()}
    assert all(words.values()), words
    by_hand = (presses + model.MAIL_PRESSES + len(model.FIELDS)) * model.PRESS_S + sum(
        map(model.typing_s, model.FIELDS.values())
    )
    assert by_hand + sum(map(model.reading_s, read.values())) <= model.WITHIN_S, words
