"""Orientation and clearance test: draw, grade, pause, clear. Right answers never leave the server."""

import random
from dataclasses import dataclass
from datetime import datetime, timedelta
from math import ceil
from typing import Any

from django.conf import settings
from django.db import IntegrityError, transaction
from django.db.models import BigAutoField, F, IntegerField, Q, QuerySet
from django.utils.timezone import localtime
from django.utils.translation import gettext, ngettext

from accounts import quiz
from accounts.bank import load_bank as load_bank
from accounts.guests import new_guest as new_guest
from accounts.guests import remove_guests as remove_guests
from accounts.models import Attempt, Choice, Clearance, OrientationRead, Question, User
from robots.dates import date_words
from robots.grants import ROBOT
from robots.kit.contract.capabilities import Preview
from robots.kit.contract.errors import NotPermitted
from robots.kit.contract.find import spec_or_none
from robots.kit.previews import Job
from robots.models import Robot
from robots.prepared import Prepared, Slot
from robots.services.streams import packets_of

_random = random.SystemRandom()
RULES = settings.FARHAND
FORGOTTEN = timedelta(days=30)  # an older failure does not extend the pause
MANY = 64
TAKE = "take"  # in a session: the robot of which a person wants control as soon as its page is open
LARGEST_STREAM = 200_000  # bytes of a byte stream that a preview reads
USER, LEVEL = Slot("user", BigAutoField()), Slot("level", IntegerField())
_CLEARED: Prepared[Any] = Prepared(lambda: cleared_people(ROBOT, LEVEL).filter(user=USER)[:1])


class NotNow(Exception):
    """The person has to do something else first, or wait; the message says what."""

    def __init__(self, text: str, wait_s: int = 0) -> None:
        super().__init__(text)
        self.wait_s = wait_s


@dataclass(frozen=True)
class ShownQuestion:
    """A question as it is shown, without the right answer."""

    id: int
    text: str
    choices: tuple[tuple[int, str], ...]
    chosen: int | None = None


@dataclass(frozen=True)
class Hint:
    """A paragraph to read again after a failed test, which does not tell which answer is right.

    `section` is the English heading, whatever the reader's language.
    """

    topic: str
    section: str
    paragraph: int


def keep_language(user: Any, language: str) -> None:
    """Store the language of mails to a person."""
    User.objects.filter(pk=user.pk).exclude(language=language).update(language=language)


def cleared(user: Any, robot: Robot, level: int = 1) -> bool:
    """Return whether the person may drive the robot."""
    if user is None or not user.is_authenticated or not user.is_active:
        return False
    if user.guest:
        return robot.guest_s is not None and level == 1
    if not robot.clearance_required:
        return True
    return bool(_CLEARED(robot=robot.pk, level=level, user=user.pk))


def is_seen(user: Any, slug: str) -> bool:
    """Return whether the pages and sockets of this robot know the person. A guest is known where people practise."""
    return (
        not user.is_authenticated
        or not user.guest
        or Robot.objects.filter(slug=slug, practice_for__isnull=False).exists()
    )


def cleared_people(robot: Robot | Slot, level: int | Slot = 1) -> QuerySet[Any, Any]:
    """Return a query for the keys of the people who have a clearance of the robot."""
    return Clearance.objects.filter(robot=robot, level__gte=level, revoked_at=None).values("user")


def preview_job(robot: Robot, user: Any, kind: str, args: dict[str, Any], joints: tuple[float, ...], n: int = 0) -> Job:
    """Return the job of a preview, for cleared people and staff; the preview starts at `joints` (rad, m).

    Nothing moves, and the job contains no secret of the robot.

    Raises:
        NotPermitted: not cleared for this robot.
    """
    if not cleared(user, robot) and not (user is not None and user.has_perm("robots.change_robot")):
        raise NotPermitted("Pass the clearance test of this robot first.")
    public = {name: value for name, value in robot.driver_settings().items() if name != "token"}
    return Job(robot.driver, public, kind, args, joints, n, _preview_packets(robot))


def _preview_packets(robot: Robot) -> tuple[tuple[bytes, bool], ...]:
    """Return the packets of the byte stream that the robot's preview needs; none of one that is too long for it."""
    spec = spec_or_none(robot.driver)
    offered = spec.capability(Preview) if spec is not None else None
    packets = packets_of(robot, offered.stream) if offered is not None and offered.stream else []
    return tuple(packets) if sum(len(data) for data, _ in packets) <= LARGEST_STREAM else ()


def has_read(user: Any, robot: Robot) -> bool:
    """Return whether the person has read the orientation."""
    return OrientationRead.objects.filter(user=user, robot=robot).exists()


def mark_read(user: Any, robot: Robot, now: datetime) -> None:
    """Note that the person has read the orientation. Raises NotNow if nobody is signed in."""
    if not user.is_authenticated:
        raise NotNow(gettext("Sign in first."))
    OrientationRead.objects.get_or_create(user=user, robot=robot, defaults={"at": now})


def _failures(user: Any, robot: Robot, now: datetime) -> QuerySet[Attempt]:
    """Return the failed tests of the last month since the last passed one, newest first.

    A failure further in the future than the longest pause was stored before the clock was set back; it does not count.
    """
    mine, longest = Attempt.objects.filter(user=user, robot=robot), timedelta(seconds=RULES["QUIZ_PAUSE_MAX_S"])
    failed = mine.filter(passed=False, finished_at__gt=now - FORGOTTEN, finished_at__lte=now + longest)
    failed = failed.order_by("-finished_at")
    last = mine.filter(passed=True).order_by("-finished_at").values_list("finished_at", flat=True).first()
    return failed.filter(finished_at__gt=last) if last else failed


def pause_left(user: Any, robot: Robot, now: datetime) -> int:
    """Return the seconds until the next attempt may start."""
    failed = list(_failures(user, robot, now).values_list("finished_at", flat=True)[:MANY])
    if not failed or failed[0] is None:
        return 0
    pause = quiz.pause_s(len(failed), RULES["QUIZ_PAUSE_S"], RULES["QUIZ_PAUSE_MAX_S"])
    return max(0, ceil((failed[0] + timedelta(seconds=pause) - now).total_seconds()))


def withdrawn_clearance(user: Any, robot: Robot) -> Clearance | None:
    """Return the clearance that staff withdrew and did not lift since; a passed test does not replace it."""
    found = Clearance.objects.filter(user=user, robot=robot).exclude(revoked_at=None)
    return found.filter(Q(lifted_at=None) | Q(lifted_at__lt=F("revoked_at"))).order_by("-revoked_at").first()


def _need_leave(user: Any, robot: Robot, now: datetime) -> None:
    """Check that the person may take the test now. Raises NotNow."""
    if not user.is_authenticated or not user.is_active:
        raise NotNow(gettext("Sign in first."))
    _need_clearable(user, robot)
    if not has_read(user, robot):
        raise NotNow(gettext("Read the orientation first."))
    wait_s = pause_left(user, robot, now)
    if wait_s:
        said = gettext("Read the orientation again; you can try again in %(pause)s.") % {"pause": in_words(wait_s)}
        raise NotNow(said, wait_s)


def _need_clearable(user: Any, robot: Robot) -> None:
    """Check that staff have not withdrawn the person's clearance. Raises NotNow."""
    if (lost := withdrawn_clearance(user, robot)) is not None and lost.revoked_at is not None:
        day = date_words(localtime(lost.revoked_at))
        said = gettext("Staff withdrew your clearance on %(day)s; only staff can lift that.") % {"day": day}
        why = gettext("Their note: %(note)s") % {"note": lost.note} if lost.note else ""
        raise NotNow(f"{said} {why}".strip())


def _lock_clearance(user: Any, robot: Robot) -> None:
    """Keep others from changing the person's clearance until the transaction ends."""
    list(Clearance.objects.select_for_update().filter(user=user, robot=robot).values_list("pk"))


def in_words(seconds: int) -> str:
    """Return a pause in the largest suitable unit."""
    if seconds >= 2 * 3600:
        return gettext("{count} hours").format(count=ceil(seconds / 3600))
    if seconds >= 2 * 60:
        return gettext("{count} minutes").format(count=ceil(seconds / 60))
    return ngettext("{count} second", "{count} seconds", seconds).format(count=seconds)


def begin(user: Any, robot: Robot, now: datetime) -> Attempt:
    """Return the person's open attempt, or draw a new one. There is at most one, also with many requests at once.

    Raises:
        NotNow: orientation not read, pause after a failure, clearance withdrawn, or no questions.
    """
    _need_leave(user, robot, now)
    mine = Attempt.objects.filter(user=user, robot=robot)
    open_one = mine.filter(finished_at=None).first()
    if open_one is not None:
        return open_one
    bank = list(Question.objects.filter(robot=robot, active=True).prefetch_related("choices"))
    if not bank:
        raise NotNow(gettext("This robot has no test yet; please come back later."))
    last = mine.order_by("-id").values_list("drawn", flat=True).first() or []
    by_id = {question.pk: question for question in bank}
    drawn = []
    for pk in quiz.draw(list(by_id), {q for q, _ in last}, RULES["QUIZ_QUESTIONS"], _random):
        choices = [c.pk for c in by_id[pk].choices.all()]
        _random.shuffle(choices)
        drawn.append([pk, choices])
    try:
        with transaction.atomic():
            return Attempt.objects.create(user=user, robot=robot, drawn=drawn, started_at=now)
    except IntegrityError as error:  # another request of the same person was faster
        open_one = mine.filter(finished_at=None).first()
        if open_one is None:
            raise NotNow(gettext("Your test was sent from another page; reload this one.")) from error
        return open_one


def questions(attempt: Attempt) -> list[ShownQuestion]:
    """Return the drawn questions in their order and in the reader's language, without the right answers."""
    ids = [q for q, _ in attempt.drawn]
    texts = dict(Question.objects.filter(pk__in=ids).values_list("pk", "text"))
    options = dict(Choice.objects.filter(question__in=ids).values_list("pk", "text"))
    return [
        ShownQuestion(q, gettext(texts[q]), tuple((c, gettext(options[c])) for c in choices if c in options))
        for q, choices in attempt.drawn
        if q in texts
    ]


def grade(attempt: Attempt, user: Any, answers: dict[int, int], now: datetime) -> list[Hint]:
    """Grade an attempt once, on the server; the same answers sent again get the same result.

    If all answers are right, the person is cleared and the list is empty; otherwise it has the paragraph of each
    wrong answer.

    Raises:
        NotNow: another person's test, a question left out, graded before, a pause, clearance withdrawn.
    """
    try:
        return _graded(attempt, user, answers, now)
    except NotNow:
        wrong = _wrong(attempt, answers)
        sent = Attempt.objects.filter(pk=attempt.pk, user=user.pk, answers=_stored(answers)).exclude(passed=None)
        if not sent.exists() or not (wrong or cleared(user, attempt.robot)):
            raise
        return _hints(wrong)


def hints_of(attempt: Attempt) -> list[Hint]:
    """Return the paragraphs to read again after a failed attempt; none of one that is open or passed."""
    if attempt.passed is not False:
        return []
    return _hints(_wrong(attempt, {int(question): choice for question, choice in attempt.answers.items()}))


def _graded(attempt: Attempt, user: Any, answers: dict[int, int], now: datetime) -> list[Hint]:
    if attempt.user_id != getattr(user, "pk", None):
        raise NotNow(gettext("That test belongs to another person."))
    _need_leave(user, attempt.robot, now)
    shown = questions(attempt)
    if len(shown) < len(attempt.drawn):
        Attempt.objects.filter(pk=attempt.pk, finished_at=None).update(finished_at=now)
        raise NotNow(gettext("The questions were changed meanwhile; begin the test again."))
    if any(q.id not in answers for q in shown):
        raise NotNow(gettext("Answer every question, then send the test."))
    wrong = _wrong(attempt, answers)
    with transaction.atomic():
        _lock_clearance(user, attempt.robot)
        _need_clearable(user, attempt.robot)  # staff may have withdrawn it while this was graded
        done = Attempt.objects.filter(pk=attempt.pk, finished_at=None).update(
            finished_at=now, answers=_stored(answers), score=len(shown) - len(wrong), passed=not wrong
        )
        if not done:
            raise NotNow(gettext("This test was already sent."))
        if not wrong:
            Clearance.objects.update_or_create(
                user=attempt.user, robot=attempt.robot, level=1,
                defaults={"granted_at": now, "revoked_at": None, "lifted_at": None, "note": ""},
            )  # fmt: skip
    return _hints(wrong)


def _stored(answers: dict[int, int]) -> dict[str, int]:
    return {str(question): choice for question, choice in answers.items()}


def _wrong(attempt: Attempt, answers: dict[int, int]) -> list[ShownQuestion]:
    shown = questions(attempt)
    right = Choice.objects.filter(question__in=[q.id for q in shown], correct=True)
    correct = dict(right.values_list("question", "pk"))
    return [q for q in shown if answers.get(q.id) != correct.get(q.id)]


def _hints(wrong: list[ShownQuestion]) -> list[Hint]:
    """Return each paragraph once, in the order of the questions."""
    about = Question.objects.in_bulk([q.id for q in wrong])
    found = [about[q.id] for q in wrong if q.id in about]
    return list(dict.fromkeys(Hint(gettext(q.topic), q.section, q.paragraph) for q in found))
