"""The verbs of the log and the survey. One verb is one function."""

from datetime import date, datetime, timedelta
from typing import Any

from django.conf import settings
from django.db import IntegrityError, transaction
from django.db.models import Exists, OuterRef, Q, QuerySet
from django.db.models.signals import post_delete
from django.dispatch import receiver
from django.utils.translation import gettext

from operatorlog.errors import LogError as LogError
from operatorlog.errors import Outdated as Outdated
from operatorlog.finds import Report, report
from operatorlog.finds import begin_first as begin_first
from operatorlog.finds import excavation_of as excavation_of
from operatorlog.models import Entry, Find, SurveyAnswer, SurveyQuestion, SurveyResponse, Visibility
from operatorlog.moderation import appeal as appeal
from operatorlog.moderation import may_appeal as may_appeal
from operatorlog.moderation import moderate as moderate
from operatorlog.moderation import to_review as to_review
from operatorlog.moderation import undo as undo
from queueing.models import Job, Turn
from queueing.services import Asker, note_answered
from robots import bus
from robots.kit.packets import Changed
from robots.models import Frame, Robot
from robots.people import is_person

LONGEST = 2000
LONGEST_ANSWER = 1000


def hand_in(
    turn: Turn, user: Any, text: str | None, frame_id: int | None, answers: dict[int, str], now: datetime,
    find: Report | None = None,
) -> tuple[Entry | None, SurveyResponse | None, Find | None]:  # fmt: skip
    """Store the form after a turn: an entry, answers, the report of a find, or several of them; all or nothing.

    `text` is None if the form had no field for an entry. Return the entry, the answers and the find, each None if the
    form had none. An unchanged entry that is sent again is not stored again.

    Raises:
        LogError: neither an entry nor an answer, or whatever `write`, `edit`, `answer_survey` and `report` refuse.
    """
    _own(turn, user)
    answers = {pk: value for pk, value in answers.items() if value.strip()}
    with transaction.atomic():
        entry = Entry.objects.filter(turn=turn).first()
        written = None
        if entry is not None and text is not None:
            written = edit(entry, user, text, frame_id, now)
        elif text is not None and text.strip():
            written = write(turn, user, text, frame_id, now)
        answered = answer_survey(turn, user, answers, now) if answers else None
        reported = report(turn, user, find, now) if find is not None else None
        if written is None and answered is None and reported is None:
            raise LogError(gettext("Write a few words or answer a question first; either is enough."))
        return written, answered, reported


def write(turn: Turn, user: Any, text: str, frame_id: int | None, now: datetime) -> Entry:
    """Store the entry of an ended turn, with a picture of that turn.

    Raises:
        LogError: another person's turn, turn not ended, empty or too long, a picture of another turn.
    """
    _own(turn, user)
    frame = _picture(turn, frame_id)
    text = _text(text)
    try:
        with transaction.atomic():
            entry = Entry.objects.create(
                turn=turn, author=user, robot=turn.robot, text=text, frame=frame, written_at=now
            )
    except IntegrityError:
        same = Entry.objects.filter(turn=turn, text=text, frame=frame).first()
        if same is None:
            raise LogError(gettext("You have written about this turn already; edit that entry.")) from None
        return same  # a double press
    _keep(entry.frame_id)
    bus.publish_on_commit(turn.robot.slug, Changed("log"))
    return entry


def may_edit(entry: Entry, user: Any, now: datetime) -> bool:
    """Return whether the author may still correct the entry."""
    minutes = timedelta(seconds=settings.FARHAND["LOG_EDIT_S"])
    return is_person(user, entry.author_id) and now < entry.written_at + minutes


def edit(entry: Entry, user: Any, text: str, frame_id: int | None, now: datetime) -> Entry:
    """Change the author's own entry within 15 minutes. Raises LogError.

    A featured entry that changes is only published until a moderator has looked again. An unchanged entry stays as it
    is.
    """
    if not is_person(user, entry.author_id):
        raise LogError(gettext("Only its author can edit an entry."))
    if not may_edit(entry, user, now):
        raise LogError(gettext("The time for corrections is over; an entry can be edited for 15 minutes."))
    text, frame = _text(text), _picture(entry.turn, frame_id)
    with transaction.atomic():
        kept = Entry.objects.select_for_update().get(pk=entry.pk)
        if (text, frame) == (kept.text, kept.frame):
            return kept
        before, kept.text, kept.frame, kept.edited_at = kept.frame_id, text, frame, now
        kept.waits, kept.revision = True, kept.revision + 1
        if kept.visibility == Visibility.FEATURED:
            kept.visibility = Visibility.PUBLISHED
        kept.save(update_fields=["text", "frame", "edited_at", "visibility", "waits", "revision"])
        _keep(before, kept.frame_id)
        bus.publish_on_commit(kept.robot.slug, Changed("log"))
    return kept


def finds_to_decide() -> QuerySet[Find]:
    """Return the reported finds on which no moderator has decided."""
    return Find.objects.filter(state=Find.State.REPORTED)


def entries_for(user: Any) -> QuerySet[Entry]:
    """Return the entries of the log that a person sees there: those that are not hidden, and their own."""
    shown = ~Q(visibility=Visibility.HIDDEN)
    return Entry.objects.filter(shown | Q(author=user.pk) if user.is_authenticated else shown)


def hidden_with(file: str) -> Entry | None:
    """Return the hidden entry about the turn of a stored picture (`frames/...`); None if no entry hides the picture."""
    of_turn = Q(frame__file=file) | Q(turn__grant__frames__file=file)
    return Entry.objects.filter(of_turn, visibility=Visibility.HIDDEN).first()


def hidden_of(grant: Any) -> Entry | None:
    """Return the hidden entry about the turn of this grant (a primary key); None if there is none."""
    return Entry.objects.filter(turn__grant=grant, visibility=Visibility.HIDDEN).first()


def stills_of(robot: Robot, day: date) -> list[str]:
    """Return the files of the stored pictures of a day (UTC) that everybody may see, the oldest first."""
    hidden = Entry.objects.filter(visibility=Visibility.HIDDEN).values("turn__grant")
    shown = Frame.objects.filter(robot=robot, taken_at__date=day).exclude(grant__in=hidden)
    return list(shown.order_by("taken_at").values_list("file", flat=True))


def may_see_hidden(entry: Entry, user: Any) -> bool:
    """Return whether the person may see the pictures of a hidden entry's turn, as staff and the author may."""
    return bool(
        user.has_perm("operatorlog.view_entry")
        or user.has_perm("robots.change_robot")
        or is_person(user, entry.author_id)
    )


def may_see_picture(entry: Entry, file: str, user: Any) -> bool:
    """Return whether the person may see one picture of a hidden entry's turn (`frames/...`).

    The robot's present operator may also see its newest picture, in which they click, and the one before it, which the
    console shows beside it.
    """
    if may_see_hidden(entry, user):
        return True
    turn = Turn.objects.filter(robot=entry.robot_id, ended_at=None).first()
    if turn is None or not is_person(user, turn.user_id):
        return False
    return file in Frame.objects.filter(robot=entry.robot_id).order_by("-id").values_list("file", flat=True)[:2]


def _own(turn: Turn, user: Any) -> None:
    if turn.robot.practice:
        raise LogError(gettext("This was practice on a simulator; the log is about the robots."))
    if not is_person(user, turn.user_id):
        raise LogError(gettext("Only the operator of a turn can write about it."))
    if turn.ended_at is None:
        raise LogError(gettext("The turn is still running; write when it has ended."))


def _text(text: str) -> str:
    text = text.strip()
    if not text:
        raise LogError(gettext("Write a few words first."))
    if len(text) > LONGEST:
        said = gettext("An entry has at most {most} characters; yours has {count}.")
        raise LogError(said.format(most=LONGEST, count=len(text)))
    return text


def _picture(turn: Turn, frame_id: int | None) -> Frame | None:
    if frame_id is None:
        return None
    frame = Frame.objects.filter(pk=frame_id, grant=turn.grant_id).first()
    if frame is None:
        raise LogError(gettext("Choose a picture of your own turn."))
    return frame


def _keep(*frames: int | None) -> None:
    """Keep these stored pictures (primary keys) as long as an entry or a find shows them, and no longer."""
    shown = Exists(Entry.objects.filter(frame=OuterRef("pk"))) | Exists(Find.objects.filter(frame=OuterRef("pk")))
    Frame.objects.filter(pk__in=[pk for pk in frames if pk is not None]).update(kept=shown)


@receiver(post_delete, sender=Entry)
@receiver(post_delete, sender=Find)
def _keep_no_longer(instance: Entry | Find, **_: Any) -> None:
    _keep(instance.frame_id)


def answer_survey(turn: Turn, user: Any, answers: dict[int, str], now: datetime) -> SurveyResponse:
    """Store the answers; questions left out are skipped.

    Raises:
        LogError: another person's turn, answered before, an unknown value.
    """
    _own(turn, user)
    good = _checked(answers, SurveyQuestion.After.TURN)
    try:
        with transaction.atomic():
            return _stored(SurveyResponse(turn=turn, at=now), good)
    except IntegrityError:
        response = SurveyResponse.objects.get(turn=turn)
        if dict(response.answers.values_list("question", "value")) != {q.pk: value for q, value in good.items()}:
            raise LogError(gettext("You have answered the survey of this turn already. Thank you!")) from None
        return response  # a double press


def answer_survey_of_job(job: Job, asker: Asker, answers: dict[int, str], now: datetime) -> SurveyResponse:
    """Store the answers of the asker of an ended job, once a job; neither the person nor the job is stored with them.

    Raises:
        LogError: another person's job, not ended, answered before, no answer at all, an unknown value.
    """
    good = _checked(answers, SurveyQuestion.After.JOB)
    if not good:
        raise LogError(gettext("Answer a question first; one is enough."))
    with transaction.atomic():
        if not note_answered(job, asker):
            raise LogError(gettext("The survey is for who asked for this job, once, after its end."))
        day = now.replace(hour=0, minute=0, second=0, microsecond=0)  # the minute would show whose answers they are
        return _stored(SurveyResponse(robot=job.robot, at=day), good)


def questions_after(what: SurveyQuestion.After) -> QuerySet[SurveyQuestion]:
    """Return the questions that are asked after a turn, or after a job."""
    return SurveyQuestion.objects.filter(active=True, after__in=(what, SurveyQuestion.After.BOTH))


def _checked(answers: dict[int, str], after: SurveyQuestion.After) -> dict[SurveyQuestion, str]:
    """Return the answers to questions that are asked. Raises LogError for a value that is no choice."""
    questions = {q.pk: q for q in questions_after(after)}
    good = {}
    for pk, value in answers.items():
        question, value = questions.get(pk), value.strip()
        if question is None or not value:
            continue
        if question.kind != question.Kind.TEXT and value not in question.choices():
            said = gettext("Choose one of the answers to “{question}”.")
            raise LogError(said.format(question=gettext(question.prompt)))
        good[question] = value[:LONGEST_ANSWER]
    return good


def _stored(response: SurveyResponse, answers: dict[SurveyQuestion, str]) -> SurveyResponse:
    response.save()
    SurveyAnswer.objects.bulk_create(
        SurveyAnswer(response=response, question=q, value=v, kind=q.kind) for q, v in answers.items()
    )
    return response
