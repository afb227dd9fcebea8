"""The verbs of moderation: decide on an entry, undo that, and ask for another look. The entry's history tells each.

Each change of an entry raises its revision. A page tells the revision that it shows, and nobody decides on another one.
"""

from datetime import datetime
from functools import partial
from typing import Any

from django.contrib.admin.models import CHANGE, LogEntry
from django.db import transaction
from django.db.models import QuerySet
from django.utils.translation import gettext, gettext_noop

from operatorlog.errors import LogError, Outdated
from operatorlog.models import Appeal, Decision, Entry, Visibility
from robots import bus
from robots.kit.packets import Changed
from robots.people import handle_of, is_person, shown_name
from robots.recordings import keeping
from robots.sentences import english

LONGEST_REASON = 200
LONGEST_WORDS = 300
LONGEST_APPEAL = 500
RULED = ("visibility", "hidden_reason", "hidden_words", "moderated_by", "moderated_at", "waits", "revision")
UNDONE, APPEALED = gettext_noop("Undone:"), gettext_noop("Another look is asked for:")


def to_review() -> QuerySet[Entry]:
    """Return the entries at which no moderator has looked, that were changed since, or whose author asks for it."""
    return Entry.objects.filter(waits=True)


def moderate(
    entry: Entry, user: Any, visibility: Visibility, reason: str, now: datetime, words: str = "",
    revision: int | None = None,
) -> Decision:  # fmt: skip
    """Publish, feature, or hide an entry; this answers an open appeal.

    Hiding needs a reason or the moderator's own words, and removes time-lapses. `revision` is what the moderator has
    read; without it, they decide on the entry as it is. The same decision twice is one.

    Raises:
        LogError: no moderator, no reason.
        Outdated: another revision.
    """
    if not user.has_perm("operatorlog.change_entry"):
        raise LogError(gettext("This is for moderators."))
    reason, words = _why(visibility, reason, words)
    with transaction.atomic():
        entry.refresh_from_db(from_queryset=Entry.objects.select_for_update())
        if revision is not None and revision != entry.revision:
            last = entry.decisions.last()
            ruled = (entry.visibility, entry.hidden_reason, entry.hidden_words)
            if last and _stands(last, entry) and is_person(user, last.by_id) and ruled == (visibility, reason, words):
                return last  # a double press
            raise _outdated(entry, last)
        made = Decision.objects.create(
            entry=entry, by=user, at=now, visibility=visibility, revision=entry.revision + 1, text=entry.text,
            picture=entry.frame.file if entry.frame else "", was_visibility=entry.visibility,
            was_reason=entry.hidden_reason, was_words=entry.hidden_words, was_waiting=entry.waits,
            was_moderated_by=entry.moderated_by, was_moderated_at=entry.moderated_at,
        )  # fmt: skip
        entry.visibility, entry.hidden_reason, entry.hidden_words = visibility, reason, words
        entry.moderated_by, entry.moderated_at, entry.waits = user, now, False
        _save(entry)
        entry.appeals.filter(answer=None).update(answer=made)
        _note(entry, user, english(visibility.label), reason, words)
    return made


def undo(decision: Decision, user: Any, now: datetime) -> bool:
    """Give an entry its state before a decision. Return whether that changed it; a second press does not.

    Raises:
        LogError: no moderator, another person's decision.
        Outdated: the entry has changed since.
    """
    if not user.has_perm("operatorlog.change_entry"):
        raise LogError(gettext("This is for moderators."))
    if not is_person(user, decision.by_id):
        raise LogError(gettext("Only who has decided can undo it. Decide anew instead."))
    with transaction.atomic():
        entry = Entry.objects.select_for_update().get(pk=decision.entry_id)
        decision.refresh_from_db()
        if decision.undone_at is not None:
            return False
        if not _stands(decision, entry):
            raise Outdated(gettext("The entry has changed since your decision, so nothing was undone. Decide anew."))
        entry.visibility = Visibility(decision.was_visibility)
        entry.hidden_reason, entry.hidden_words = decision.was_reason, decision.was_words
        entry.moderated_by, entry.moderated_at = decision.was_moderated_by, decision.was_moderated_at
        entry.waits, decision.undone_at = decision.was_waiting, now
        _save(entry)
        decision.save(update_fields=["undone_at"])
        decision.appeals.update(answer=None)
        _note(entry, user, UNDONE, english(Visibility(decision.visibility).label))
    return True


def may_appeal(entry: Entry, user: Any) -> bool:
    """Return whether the person may ask for another look: the author, once for what a moderator has read."""
    if entry.visibility != Visibility.HIDDEN or not is_person(user, entry.author_id):
        return False
    last = entry.appeals.select_related("answer").last()
    if last is None:
        return True
    read = last.answer
    return read is not None and (entry.text, entry.frame.file if entry.frame else "") != (read.text, read.picture)


def appeal(entry: Entry, user: Any, words: str, now: datetime) -> Appeal:
    """Ask for another look at the author's own hidden entry. Raises LogError."""
    if not is_person(user, entry.author_id):
        raise LogError(gettext("Only its author can ask for another look at an entry."))
    words = words.strip()
    if not words:
        raise LogError(gettext("Say in a few words why a moderator should look again."))
    if len(words) > LONGEST_APPEAL:
        said = gettext("Use at most {most} characters to say why; yours are {count}.")
        raise LogError(said.format(most=LONGEST_APPEAL, count=len(words)))
    with transaction.atomic():
        entry.refresh_from_db(from_queryset=Entry.objects.select_for_update())
        last = entry.appeals.last()
        if last is not None and last.answer_id is None and last.words == words:
            return last  # a double press
        if entry.visibility != Visibility.HIDDEN:
            raise LogError(gettext("This entry is not hidden."))
        if not may_appeal(entry, user):
            raise LogError(gettext("You have asked for another look at this entry already."))
        made = Appeal.objects.create(entry=entry, words=words, at=now)
        entry.waits = True
        _save(entry)
        _note(entry, user, APPEALED, words)
    return made


def _why(visibility: Visibility, reason: str, words: str) -> tuple[str, str]:
    """Return what is stored; only hiding has a reason, and needs one. Raises LogError."""
    if visibility != Visibility.HIDDEN:
        return "", ""
    reason, words = reason.strip(), " ".join(words.split())
    if not reason and not words:
        raise LogError(gettext("Give the reason for hiding it; the author sees it."))
    for text, most in ((reason, LONGEST_REASON), (words, LONGEST_WORDS)):
        if len(text) > most:
            said = gettext("A reason has at most {most} characters; yours has {count}.")
            raise LogError(said.format(most=most, count=len(text)))
    return reason, words


def _stands(decision: Decision, entry: Entry) -> bool:
    """Return whether nothing has changed the entry since the decision."""
    return decision.undone_at is None and decision.revision == entry.revision


def _outdated(entry: Entry, last: Decision | None) -> Outdated:
    if last is None or not _stands(last, entry):
        return Outdated(gettext("The entry has changed since you opened it, so nothing was done. Read it again."))
    said = gettext("{name} has decided meanwhile, so nothing was done. The entry is now: {state}.")
    state = str(entry.get_visibility_display())
    if entry.why_hidden:
        state = f"{state} ({entry.why_hidden})"
    return Outdated(said.format(name=shown_name(handle_of(last.by)), state=state))


def _save(entry: Entry) -> None:
    entry.revision += 1
    entry.save(update_fields=RULED)
    if entry.visibility == Visibility.HIDDEN:  # after the transaction, so that no time-lapse is made again before it
        transaction.on_commit(partial(keeping.forget_lapses, entry.turn.grant), robust=True)
    bus.publish_on_commit(entry.robot.slug, Changed("log"))


def _note(entry: Entry, user: Any, *lines: str) -> None:
    """Note in the history what was done; lines of the site's own texts are in English, and translated when read."""
    message = "\n".join(filter(None, lines))
    LogEntry.objects.log_actions(user.pk, [entry], CHANGE, message, single_object=True)
