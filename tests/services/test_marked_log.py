"""Every text of the log, of finds, surveys, recordings and accounts is marked: none is left in the pseudo-language."""

import re
from types import SimpleNamespace

import pytest

from accounts import services
from accounts.models import Attempt, Choice
from operatorlog.models import SurveyQuestion
from portal.keep.seeding import JOB_SURVEY, SURVEY
from queueing.models import Turn
from robots.kit.clock import SYSTEM
from robots.models import Movie, Recording, RecordingState
from tests.services.browsers import signed_in
from tests.services.test_marked_texts import PSEUDO, TURNED, WORD, unmarked

pytestmark = [pytest.mark.service, pytest.mark.django_db]

# what people wrote, addresses, formats, units
DATA = re.compile(
    r"Rude words\.|not kind|a spoon|=chess|\w+@example\.org|MP4 \(H\.264\)|WebM \(VP9\)|MP4|MCAP|\bcm\b|\bscout\b"
)
KIND = re.compile(r"Move to")  # of a command that the robot no longer has
ACCOUNTS = ["/accounts/login/", "/accounts/signup/", "/accounts/password/reset/", "/accounts/password/reset/done/", "/accounts/confirm-email/"]  # fmt: skip


def left(answer):
    """Return the texts of a page that are not marked; the orientation of a robot is a file of its own."""
    page = re.sub(r'<article class="prose".*?</article>', "", answer.text, flags=re.DOTALL)
    texts = [KIND.sub("", DATA.sub("", TURNED.sub("", text))) for text in unmarked(SimpleNamespace(text=page))]
    return [text for text in texts if WORD.search(text)]


@pytest.fixture
def asked(used):
    """The survey that an installation begins with, in place of the one of other tests."""
    for question, (prompt, kind, options, low, high) in zip(
        SurveyQuestion.objects.order_by("id"), (SURVEY[0], JOB_SURVEY[0], SURVEY[3]), strict=True
    ):
        question.prompt, question.kind, question.options = prompt, kind, "\n".join(options)
        question.low_label, question.high_label = low, high
        question.save()
    return used


@pytest.mark.parametrize("role", ["", "ada", "bob", "eve", "root"])  # a driver, a hidden author, a candidate, staff
def test_no_text_of_log_recordings_and_accounts_is_left_in_english(asked, role):
    browser = signed_in(asked.get(role), headers={"accept-language": PSEUDO})
    pages = ["/log/", "/robots/mercury/finds/", "/movie-of-the-day/", "/robots/mercury/orientation/", *ACCOUNTS]
    pages += ["/robots/mercury/clearance/", *(f"/robots/{slug}/recordings/" for slug in ("mercury", "pa10", "irat"))]
    pages += [turn.get_absolute_url() for turn in Turn.objects.all()]
    pages += [recording.get_absolute_url() for recording in Recording.objects.all()]
    pages += ["/survey/results/"] if role == "root" else []
    found = {path: left(browser.get(path, follow=True)) for path in pages}
    assert {path: texts for path, texts in found.items() if texts} == {}


def test_no_text_of_a_failed_test_is_left_in_english(robot, people):
    services.load_bank(robot)
    services.mark_read(people["eve"], robot, SYSTEM.now())
    browser = signed_in(people["eve"], headers={"accept-language": PSEUDO})
    for _ in range(2):  # the second failure costs a pause
        assert left(browser.get("/robots/mercury/clearance/")) == []
        attempt = Attempt.objects.get(finished_at=None)
        wrong = Choice.objects.filter(question__in=[q for q, _ in attempt.drawn], correct=False)
        data = {"attempt": attempt.pk} | {f"q{one.question_id}": one.pk for one in wrong}
        failed = browser.post("/robots/mercury/clearance/", data, follow=True)
        sections = [hint["section"] for hint in failed.context["hints"]]  # of the orientation, not in this language
        assert [text for text in left(failed) if not any(section in text for section in sections)] == []
    pause = browser.get("/robots/mercury/clearance/")
    assert (pause.status_code, left(pause)) == (409, [])


@pytest.mark.parametrize("state", list(Movie.State))
def test_no_text_about_movies_is_left_in_english(asked, state):
    Recording.objects.update(state=RecordingState.READY, dropped=1)
    Movie.objects.update(state=state, reason="Too many movies wait to be made; ask again in some minutes.", tries=2)
    browser = signed_in(asked["root"], headers={"accept-language": PSEUDO})
    turn = Turn.objects.exclude(ended_at=None).first()
    for path in ("/robots/mercury/recordings/", turn.get_absolute_url(), Recording.objects.first().get_absolute_url()):
        assert left(browser.get(path)) == [], path
