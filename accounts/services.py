"""Orientation and clearance: draw, grade, pause, clear. The key never leaves the server."""

import random
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from django.conf import settings
from django.db import transaction

from accounts.models import Attempt, Choice, Clearance, OrientationRead, Question
from robots.models import Robot

_random = random.SystemRandom()


class NotNow(Exception):
    """The person has to do something else first, or wait; the text says what."""

    def __init__(self, text: str, wait_s: int = 0) -> None:
        super().__init__(text)
        self.wait_s = wait_s


@dataclass(frozen=True)
class Shown:
    """A question as it is shown: no key in it."""

    id: int
    text: str
    choices: tuple[tuple[int, str], ...]
    chosen: int | None = None


@dataclass(frozen=True)
class Feedback:
    """A wrong answer and why."""

    question: str
    answered: str
    explanation: str


def cleared(user: Any, robot: Robot, level: int = 1) -> bool:
    """Tell whether the person may drive the robot."""
    if user is None or not user.is_authenticated or not user.is_active:
        return False
    if not robot.clearance_required:
        return True
    return Clearance.objects.filter(user=user, robot=robot, level__gte=level, revoked_at=None).exists()


def has_read(user: Any, robot: Robot) -> bool:
    """Tell whether the person has read the orientation."""
    return OrientationRead.objects.filter(user=user, robot=robot).exists()


def mark_read(user: Any, robot: Robot, now: datetime) -> None:
    """Remember that the person has read the orientation."""
    OrientationRead.objects.get_or_create(user=user, robot=robot, defaults={"at": now})


def pause_left(user: Any, robot: Robot, now: datetime) -> int:
    """Return the seconds until another attempt may begin."""
    last = Attempt.objects.filter(user=user, robot=robot, passed=False).order_by("-finished_at").first()
    if last is None or last.finished_at is None:
        return 0
    until = last.finished_at + timedelta(seconds=settings.FARHAND["QUIZ_PAUSE_S"])
    return max(0, round((until - now).total_seconds()))


def begin(user: Any, robot: Robot, now: datetime) -> Attempt:
    """Return the person's open attempt, or draw a new one.

    Raises:
        NotNow: orientation not read, pause after a failure, or no questions.

    """
    if not has_read(user, robot):
        raise NotNow("Read the orientation first.")
    wait_s = pause_left(user, robot, now)
    if wait_s:
        raise NotNow(f"Have another look at the orientation; you can try again in {wait_s} seconds.", wait_s)
    open_one = Attempt.objects.filter(user=user, robot=robot, finished_at=None).order_by("-id").first()
    if open_one is not None:
        return open_one
    bank = list(Question.objects.filter(robot=robot, active=True).prefetch_related("choices"))
    if not bank:
        raise NotNow("This robot has no test yet; please come back later.")
    count = min(len(bank), settings.FARHAND["QUIZ_QUESTIONS"])
    drawn = []
    for question in _random.sample(bank, count):
        choices = [c.pk for c in question.choices.all()]
        _random.shuffle(choices)
        drawn.append([question.pk, choices])
    return Attempt.objects.create(user=user, robot=robot, drawn=drawn, started_at=now)


def questions(attempt: Attempt) -> list[Shown]:
    """Return the drawn questions in their order, without the key."""
    ids = [q for q, _ in attempt.drawn]
    texts = dict(Question.objects.filter(pk__in=ids).values_list("pk", "text"))
    options = dict(Choice.objects.filter(question__in=ids).values_list("pk", "text"))
    return [
        Shown(q, texts[q], tuple((c, options[c]) for c in choices if c in options))
        for q, choices in attempt.drawn
        if q in texts
    ]


def grade(attempt: Attempt, answers: dict[int, int], now: datetime) -> list[Feedback]:
    """Score an attempt once, on the server; all right gives the clearance.

    Raises:
        NotNow: a question was left out, or the attempt was graded before.

    """
    shown = questions(attempt)
    if any(q.id not in answers for q in shown):
        raise NotNow("Answer every question, then send the test.")
    correct = dict(
        Choice.objects.filter(question__in=[q.id for q in shown], correct=True).values_list("question", "pk")
    )
    wrong = [q for q in shown if answers[q.id] != correct.get(q.id)]
    with transaction.atomic():
        done = Attempt.objects.filter(pk=attempt.pk, finished_at=None).update(
            finished_at=now,
            answers={str(k): v for k, v in answers.items()},
            score=len(shown) - len(wrong),
            passed=not wrong,
        )
        if not done:
            raise NotNow("This test was already sent.")
        if not wrong:
            Clearance.objects.update_or_create(
                user=attempt.user, robot=attempt.robot, level=1, defaults={"granted_at": now, "revoked_at": None}
            )
    explanations = dict(Question.objects.filter(pk__in=[q.id for q in wrong]).values_list("pk", "explanation"))
    return [Feedback(q.text, dict(q.choices).get(answers[q.id], "—"), explanations[q.id]) for q in wrong]
