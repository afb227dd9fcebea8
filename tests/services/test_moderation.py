"""Moderation: decisions one after the other, their undo, appeals, and what the history of an entry tells."""

import re

import pytest
from django.contrib.admin.models import LogEntry
from django.contrib.auth.models import Permission
from django.test import Client

from accounts.models import User
from operatorlog import services as log
from operatorlog.models import Appeal, Decision, Entry, HidingReason, Visibility
from queueing import services as queue
from robots.kit.clock import SYSTEM
from robots.states import GrantEnd
from tests.services.browsers import signed_in
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("owned")]
REVIEW = "/admin/operatorlog/entry/review/"
PUBLISHED, FEATURED, HIDDEN = Visibility.PUBLISHED, Visibility.FEATURED, Visibility.HIDDEN


def written(robot, person, text):
    turn = drive(robot, person, SYSTEM.now())
    queue.end_turn(turn, GrantEnd.HOLDER, "x", SYSTEM.now())
    turn.refresh_from_db()
    type(robot).objects.update(cycle="ready")
    return log.write(turn, person, text, None, SYSTEM.now())


@pytest.fixture
def entry(robot, people):
    return written(robot, people["ada"], "A watch in the sand.")


@pytest.fixture
def reason():
    """A reason of the migration, which another test may have removed."""
    return HidingReason.objects.get_or_create(text="It is unkind to somebody.")[0]


@pytest.fixture
def second(people):
    """Another moderator."""
    made = User.objects.create_user("mia", "mia@example.org", "correct horse 42", is_staff=True)
    made.user_permissions.set(Permission.objects.filter(codename__in=("view_entry", "change_entry")))
    return User.objects.get(pk=made.pk)


@pytest.fixture
def mod(people):
    return signed_in(people["mod"])


def page_of(entry):
    return f"/admin/operatorlog/entry/{entry.pk}/change/"


def decide(client, entry, visibility, revision=None, **more):
    form = {"visibility": visibility, "revision": entry.revision if revision is None else revision, **more}
    return client.post(page_of(entry), form)


def fresh(entry):
    return Entry.objects.get(pk=entry.pk)


def state(entry):
    """Return what an undo has to bring back."""
    names = ("visibility", "hidden_reason", "hidden_words", "moderated_by", "moderated_at", "waits")
    return Entry.objects.filter(pk=entry.pk).values(*names).get()


def noted(entry, client):
    """Return the rows of the entry's history, the oldest first."""
    html = client.get(f"/admin/operatorlog/entry/{entry.pk}/history/").content.decode()
    rows = re.findall(r"<tr>\s*<th scope=\"row\">.*?</th>\s*<td>(.*?)</td>\s*<td>(.*?)</td>", html, re.DOTALL)
    return [(name.strip(), " ".join(text.split())) for name, text in rows]


def test_a_moderator_goes_from_entry_to_entry_the_oldest_first_and_leaves_some_for_later(robot, people, mod):
    first, other, third = (written(robot, people[name], f"text {n}") for n, name in enumerate(("ada", "bob", "ada")))
    assert b"3 entries wait." in mod.get(REVIEW).content
    assert b"text 0" in mod.get(REVIEW).content
    later = f"{REVIEW}?after={first.pk}"
    assert f'href="{later}"' in mod.get(REVIEW).content.decode()
    assert b"text 1" in mod.get(later).content
    answer = decide(mod, other, "featured", after=first.pk)
    assert (answer.status_code, fresh(other).visibility) == (302, FEATURED)
    following = mod.get(answer["Location"]).content.decode()
    assert "text 2" in following and "text 0" not in following
    assert "Featured: the entry of bob, “text 1”." in following
    answer = decide(mod, third, "published", after=first.pk)
    end = mod.get(answer["Location"]).content.decode()
    assert "1 entry waits." in end
    assert "left some for later" in end
    decide(mod, first, "published")
    assert b"Nothing waits." in mod.get(REVIEW).content


def test_a_reason_is_chosen_or_written_and_the_author_reads_it_in_their_language(entry, people, mod, reason):
    answer = decide(mod, entry, "hidden")
    assert answer.status_code == 422
    assert b"Give the reason for hiding it" in answer.content
    answer = decide(mod, entry, "hidden", reason=reason.pk, words=" See the   rules. ")
    assert answer.status_code == 302
    assert fresh(entry).why_hidden == f"{reason.text} See the rules."
    for language, text in (("en", "It is unkind to somebody."), ("de", "Er ist unfreundlich zu jemandem.")):
        author = signed_in(people["ada"], headers={"accept-language": language})
        assert f"{text} See the rules." in author.get(entry.turn.get_absolute_url()).content.decode()


def test_reasons_are_edited_by_staff_and_one_that_is_off_is_not_on_offer(entry, people, mod):
    people["mod"].user_permissions.add(*Permission.objects.filter(codename__endswith="_hidingreason"))
    added = {"text": "It is a riddle.", "position": "9", "active": "on"}
    assert mod.post("/admin/operatorlog/hidingreason/add/", added).status_code == 302
    reason = HidingReason.objects.get(text="It is a riddle.")
    assert "It is a riddle." in mod.get(REVIEW).content.decode()
    HidingReason.objects.filter(pk=reason.pk).update(active=False)
    assert "It is a riddle." not in mod.get(REVIEW).content.decode()
    answer = decide(mod, entry, "hidden", reason=reason.pk, words="mine")
    assert answer.status_code == 422
    assert b'value="mine"' in answer.content, "nothing that was typed is lost"
    assert fresh(entry).visibility == PUBLISHED


@pytest.mark.parametrize("form", [
    {"visibility": "gone"}, {}, {"visibility": "hidden", "reason": "x"}, {"visibility": "hidden", "reason": "9" * 30},
    {"visibility": "hidden", "words": "w" * 301},
])  # fmt: skip
def test_a_form_that_makes_no_sense_is_answered_with_a_sentence(entry, mod, form):
    answer = mod.post(page_of(entry), {"revision": "0", **form})
    assert answer.status_code == 422
    assert re.search(r'class="errornote" role="alert">[A-Z][^<]+\.', answer.content.decode())
    assert state(entry)["waits"]


@pytest.mark.parametrize("after", ["", "x", "-1", "9" * 40, "1e3"])
def test_an_address_that_makes_no_sense_shows_the_oldest(entry, mod, after):
    assert entry.text in mod.get(REVIEW, {"after": after, "done": after}).content.decode()


@pytest.mark.parametrize("wanted", [PUBLISHED, FEATURED, HIDDEN])
def test_undo_brings_back_what_was_before(entry, people, mod, wanted):
    log.moderate(entry, people["mod"], HIDDEN, "rude", SYSTEM.now(), "Very.")
    log.appeal(fresh(entry), people["ada"], "It was a joke.", SYSTEM.now())
    before = state(entry)
    answer = decide(mod, fresh(entry), wanted, words="no")
    assert state(entry) != before
    page = mod.get(answer["Location"]).content.decode()
    key = re.search(r'name="undo" value="(\d+)"', page)[1]
    answers = [mod.post(REVIEW, {"undo": key}) for _ in range(2)]
    assert [one.status_code for one in answers] == [302, 302], "a second press is no error"
    assert answers[0]["Location"].startswith(page_of(entry))
    assert "It is undone." in mod.get(answers[1]["Location"]).content.decode(), "whichever answer is shown"
    assert state(entry) == before
    assert Appeal.objects.get().answer is None, "it is open again"
    assert [text for _, text in noted(entry, mod)].count(f"Undone: {wanted.label}") == 1
    assert 'name="undo"' not in mod.get(answer["Location"]).content.decode()


def test_undo_of_a_second_thought_brings_back_a_decision_and_the_entry_does_not_wait(entry, people):
    log.moderate(entry, people["mod"], FEATURED, "", SYSTEM.now())
    before = state(entry)
    made = log.moderate(entry, people["mod"], HIDDEN, "rude", SYSTEM.now())
    assert log.undo(made, people["mod"], SYSTEM.now())
    assert state(entry) == before
    assert not log.to_review().exists()


def test_undo_is_refused_when_the_entry_has_changed_since(entry, people, mod, second):
    made = log.moderate(entry, people["mod"], FEATURED, "", SYSTEM.now())
    log.edit(entry, people["ada"], "A clock.", None, SYSTEM.now())
    before = state(entry)
    answer = mod.post(REVIEW, {"undo": made.pk})
    assert answer.status_code == 409
    assert "changed since your decision" in answer.content.decode()
    assert state(entry) == before
    mine = log.moderate(entry, people["mod"], PUBLISHED, "", SYSTEM.now())
    log.moderate(entry, second, HIDDEN, "rude", SYSTEM.now())
    assert mod.post(REVIEW, {"undo": mine.pk}).status_code == 409
    assert fresh(entry).visibility == HIDDEN


def test_who_comes_second_is_told_who_decided_what_and_overwrites_nothing(entry, people, mod, second):
    assert decide(signed_in(second), entry, "hidden", words="It is rude.").status_code == 302
    before = state(entry)
    answer = decide(mod, entry, "featured")
    assert answer.status_code == 409
    text = answer.content.decode()
    assert "mia has decided meanwhile, so nothing was done. The entry is now: Hidden (It is rude.)." in text
    assert state(entry) == before
    assert decide(mod, entry, "hidden", words="It is rude.").status_code == 409, "the same, but another person's"
    assert Decision.objects.count() == 1
    now = re.search(r'name="revision" value="(\d+)"', text)[1]
    assert decide(mod, entry, "featured", int(now)).status_code == 302, "having read that, they may"


def test_what_the_author_changed_meanwhile_is_read_first(entry, people, mod):
    old = entry.revision
    log.edit(entry, people["ada"], "A clock.", None, SYSTEM.now())
    answer = decide(mod, entry, "hidden", old, words="too long")
    assert answer.status_code == 409
    text = answer.content.decode()
    assert "Read it again" in text
    assert "A clock." in text
    assert 'value="too long"' in text
    assert fresh(entry).waits


def test_a_second_press_is_one_decision(entry, mod):
    answers = [decide(mod, entry, "hidden", words="rude") for _ in range(2)]
    assert answers[0]["Location"] == answers[1]["Location"]
    assert Decision.objects.count() == LogEntry.objects.count() == 1


def test_what_was_changed_stands_beside_what_a_moderator_read(entry, people, mod):
    log.moderate(entry, people["mod"], PUBLISHED, "", SYSTEM.now())
    assert "What a moderator read before" not in mod.get(page_of(entry)).content.decode()
    log.edit(entry, people["ada"], "A clock.", None, SYSTEM.now())
    text = mod.get(REVIEW).content.decode()
    assert "Changed since a moderator looked" in text
    assert '<blockquote class="before">A watch in the sand.' in text
    assert '<blockquote class="says">A clock.' in text


def test_the_history_tells_decisions_undo_and_appeals(entry, people, mod, second, reason):
    log.moderate(entry, people["mod"], HIDDEN, reason.text, SYSTEM.now(), "Twice.")
    log.appeal(entry, people["ada"], "It was a joke.", SYSTEM.now())
    made = log.moderate(entry, second, FEATURED, "", SYSTEM.now())
    log.undo(made, second, SYSTEM.now())
    signed_in(people["mod"]).post(
        "/admin/operatorlog/entry/", {"action": "publish", "_selected_action": [str(entry.pk)]}
    )
    assert noted(entry, mod) == [
        ("mod", f"Hidden {reason.text} Twice."), ("ada", "Another look is asked for: It was a joke."),
        ("mia", "Featured"), ("mia", "Undone: Featured"), ("mod", "Published"),
    ]  # fmt: skip
    german = noted(entry, signed_in(people["mod"], headers={"accept-language": "de"}))
    assert german[0] == ("mod", "Verborgen Er ist unfreundlich zu jemandem. Twice.")


def appeal(client, entry, words="It was a joke."):
    return client.post(entry.turn.get_absolute_url(), {"appeal": words})


def test_an_author_asks_once_and_reads_the_outcome(entry, people, mod):
    ada, place = signed_in(people["ada"]), entry.turn.get_absolute_url()
    assert appeal(ada, entry).status_code == 422, "it is not hidden"
    log.moderate(entry, people["mod"], HIDDEN, "rude", SYSTEM.now())
    assert 'name="appeal"' in ada.get(place).content.decode()
    assert appeal(ada, entry).status_code == 302
    assert appeal(ada, entry).status_code == 302, "the same press twice"
    answer = appeal(ada, entry, "And another word.")
    assert answer.status_code == 422
    assert "And another word." in answer.content.decode()
    assert Appeal.objects.count() == 1
    page = ada.get(place).content.decode()
    assert "A moderator has not decided on it yet." in page
    assert 'name="appeal"' not in page
    queue_page = mod.get(REVIEW).content.decode()
    assert "It was a joke." in queue_page
    assert "Why it is hidden: rude" in queue_page
    log.moderate(fresh(entry), people["mod"], HIDDEN, "still rude", SYSTEM.now())
    page = ada.get(place).content.decode()
    assert "the entry stays hidden" in page
    assert 'name="appeal"' not in page
    assert appeal(ada, entry, "Once more.").status_code == 422
    log.edit(fresh(entry), people["ada"], "A watch.", None, SYSTEM.now())
    assert appeal(ada, entry, "I have corrected it.").status_code == 302, "it is another text"
    log.moderate(fresh(entry), people["mod"], PUBLISHED, "", SYSTEM.now())
    assert "the entry is published" in ada.get(place).content.decode()
    assert "I have corrected it." not in Client().get(place).content.decode(), "nobody else reads it"


def test_an_appeal_waits_on_the_first_page_with_its_words(entry, people, mod):
    log.moderate(entry, people["mod"], HIDDEN, "rude", SYSTEM.now())
    assert "another look" not in mod.get("/admin/live/").content.decode()
    log.appeal(entry, people["ada"], "It was a joke.", SYSTEM.now())
    text = mod.get("/admin/live/").content.decode()
    assert "ada asks for another look at a hidden entry about Mercury." in text
    assert f'href="{REVIEW}"' in text
    assert f'href="{page_of(entry)}"' in text


@pytest.mark.parametrize("words", ["", "  ", "w" * 501])
def test_an_appeal_has_a_few_words(entry, people, words):
    log.moderate(entry, people["mod"], HIDDEN, "rude", SYSTEM.now())
    assert appeal(signed_in(people["ada"]), entry, words).status_code == 422
    assert not Appeal.objects.exists()


@pytest.mark.asvs("8.2.2")
@pytest.mark.parametrize(("role", "status"), [("bob", 403), ("mod", 403), ("kim", 403), (None, 302)])
def test_nobody_asks_for_another_persons_entry(entry, people, role, status):
    log.moderate(entry, people["mod"], HIDDEN, "rude", SYSTEM.now())
    assert appeal(signed_in(people.get(role)), entry).status_code == status
    assert not Appeal.objects.exists()
    assert not fresh(entry).waits


@pytest.mark.asvs("8.2.1")
def test_who_moderates_nothing_sees_no_queue_and_decides_and_undoes_nothing(entry, people):
    made = log.moderate(entry, people["mod"], FEATURED, "", SYSTEM.now())
    viewer = User.objects.create_user("vic", "vic@example.org", "correct horse 42", is_staff=True)
    viewer.user_permissions.set(Permission.objects.filter(codename__startswith="view_"))
    before = state(entry)
    for person, seen in ((viewer, 200), (people["kim"], 403), (people["ada"], 302), (None, 302)):
        client = signed_in(person)
        refused = 302 if seen == 302 else 403
        assert client.get(REVIEW).status_code == refused
        assert client.get(page_of(entry)).status_code == seen
        assert decide(client, entry, "hidden", words="x").status_code == refused
        assert client.post(REVIEW, {"undo": made.pk}).status_code == refused
    assert 'name="visibility"' not in signed_in(viewer).get(page_of(entry)).content.decode()
    assert state(entry) == before


@pytest.mark.asvs("8.2.2")
def test_another_moderators_decision_is_not_undone_nor_told_as_ones_own(entry, people, mod, second):
    made = log.moderate(entry, second, FEATURED, "", SYSTEM.now())
    assert 'name="undo"' not in mod.get(REVIEW, {"done": made.pk}).content.decode()
    answer = mod.post(REVIEW, {"undo": made.pk})
    assert answer.status_code == 403
    assert "Only who has decided can undo it." in answer.content.decode()
    for key in ("", "0", "x", "9" * 18, "9" * 40):
        assert mod.post(REVIEW, {"undo": key}).status_code == 404
    assert fresh(entry).visibility == FEATURED


def test_a_link_in_a_text_changes_nothing_and_a_get_decides_nothing(entry, mod):
    before = state(entry)
    mod.get(page_of(entry), {"visibility": "hidden", "words": "x", "revision": "0"})
    mod.get(REVIEW, {"undo": "1"})
    assert mod.put(REVIEW).status_code == 405
    assert state(entry) == before
    strict = Client(enforce_csrf_checks=True)
    strict.cookies = mod.cookies
    assert decide(strict, entry, "hidden", words="x").status_code == 403
    assert state(entry) == before
