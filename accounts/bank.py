"""The questions of the clearance test that a robot's package brings."""

import tomllib

from django.db import transaction

from accounts.models import Choice, Question
from robots.kit import description
from robots.models import Robot


@transaction.atomic
def load_bank(robot: Robot) -> int:
    """Fill a question bank that is empty or whose questions have no topics yet. Return how many were added.

    Either all are added or none.

    Raises:
        OSError: the package has no `clearance.toml`.
        LookupError, TypeError, ValueError, DataError: the file cannot be read.
    """
    mine = Question.objects.filter(robot=robot)
    if mine.exists() and not mine.filter(topic="").exists():
        return 0
    added = 0
    for one in tomllib.loads(description.text_of(robot.driver, "clearance.toml"))["question"]:
        about = {name: one[name] for name in ("topic", "section", "paragraph") if name in one}
        if mine.filter(text=one["text"]).update(**about) if about else mine.filter(text=one["text"]).exists():
            continue
        question = Question.objects.create(
            robot=robot, text=one["text"], explanation=one.get("explanation", ""), **about
        )
        Choice.objects.bulk_create(
            Choice(question=question, text=text, correct=number == 0) for number, text in enumerate(one["choices"])
        )
        added += 1
    return added
