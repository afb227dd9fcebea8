"""What docs/reference/data-and-logs.md promises about keeping, deleting and naming; each test quotes its sentence."""

from datetime import timedelta
from pathlib import Path

import pytest
from django.contrib.sessions.models import Session
from django.test import Client

from accounts.models import Attempt, Clearance, User
from operatorlog.models import Entry, SurveyAnswer, SurveyResponse
from queueing.models import OPEN_JOB, Account, Job, Ticket, Turn, TurnSession
from queueing.services import Asker, ask
from robots.grants import open_grant
from robots.kit.clock import SYSTEM
from robots.models import Command, Frame, Program, Recording, Robot
from tests.services.admin_forms import as_sent, controls_of
from tests.services.browsers import signed_in
from tests.services.test_later_changes import addresses
from workers.housekeeping.clean import old_frames, old_sessions

pytestmark = pytest.mark.django_db
DAY = timedelta(days=1)


@pytest.fixture
def root(used):
    return signed_in(used["root"])


def delete(root, row):
    """Delete a row as staff do."""
    page = f"/admin/{row._meta.app_label}/{row._meta.model_name}/{row.pk}/delete/"
    assert root.post(page, {"post": "yes"}).status_code == 302, page


def told(client):
    """Return what all pages for everybody show this visitor."""
    return "".join(
        client.get(address).content.decode(errors="replace") for address in addresses()[0] if "survey" not in address
    )


@pytest.mark.service
def test_a_name_is_shown_until_the_account_is_deleted_and_turns_stay_without_it(used, root):
    """name (handle) | everybody | until the account is deleted. [...] its turns and log entries stay without a name."""
    entry, turns = Entry.objects.get(author=used["ada"]), Turn.objects.filter(user=used["ada"]).count()
    assert turns == 2
    text = "I found a watch."
    assert ">ada " in told(Client())
    delete(root, used["ada"])
    shown = told(Client())
    assert "ada" not in shown.replace("Canada", "").split()
    assert ">ada" not in shown
    assert "Deleted account" in shown
    assert text in shown
    entry.refresh_from_db()
    assert Turn.objects.filter(user=None).count() == turns
    assert (entry.author, entry.turn.ticket) == (None, None)
    assert Command.objects.filter(grant=entry.turn.grant).get().issued_by is None
    assert Recording.objects.filter(grant=entry.turn.grant).exists()
    assert SurveyResponse.objects.filter(turn=entry.turn).exists()


@pytest.mark.service
def test_deleting_an_account_deletes_what_is_of_its_own(used, root):
    """Deleting an account in the admin deletes its sessions, tickets, attempts, clearances, jobs and programs."""
    rows = (Ticket, Attempt, Clearance, Job, Account)
    eve, ada = used["eve"], used["ada"]
    for person in (ada, eve):
        here = signed_in(person)
        assert here.get("/me/").status_code == 200
        number = person.pk
        assert any(model.objects.filter(user=number).exists() for model in rows)
        delete(root, person)
        assert not any(model.objects.filter(user=number).exists() for model in rows)
        assert not Program.objects.filter(author=number).exists()
        assert here.get("/me/").status_code == 302
        assert not any(one.get_decoded().get("_auth_user_id") == str(number) for one in Session.objects.all())
    assert Program.objects.filter(author=None).exists(), "that of the robot"


@pytest.mark.service
def test_deleting_an_account_ends_its_turn_and_its_jobs_first(used, root, robot):
    """Its turn, its places and its jobs are ended first; the robot holds."""
    ada, irat = used["ada"], Robot.objects.get(slug="irat")
    turn = Turn.objects.get(user=ada, ended_at=None)
    job = ask(irat, Asker(user=ada), "goal", {"map": 1, "x": 0.1, "y": 0.1}, SYSTEM.now())
    assert job.state in OPEN_JOB
    delete(root, ada)
    turn.refresh_from_db()
    turn.grant.refresh_from_db()
    assert (turn.end_reason, turn.grant.end_code) == ("account deleted", "unfit")
    assert turn.grant.ended_at is not None
    assert open_grant(robot) is None
    assert not Job.objects.filter(pk=job.pk).exists()


def test_who_may_not_delete_an_account_deletes_none_with_what_it_did(used, root):
    client = signed_in(used["mod"])
    assert client.post(f"/admin/accounts/user/{used['ada'].pk}/delete/", {"post": "yes"}).status_code in (302, 403)
    assert User.objects.filter(pk=used["ada"].pk).exists()


def test_a_mail_address_is_read_by_its_person_and_staff_who_may_see_accounts(used, root):
    """mail address | the person, staff who may see accounts."""
    address = used["ada"].email
    assert address in signed_in(used["ada"]).get("/accounts/email/").content.decode()
    assert address in root.get(f"/admin/accounts/user/{used['ada'].pk}/change/").content.decode()
    for visitor in (Client(), signed_in(used["bob"])):
        assert address not in told(visitor)
    assert signed_in(used["mod"]).get(f"/admin/accounts/user/{used['ada'].pk}/change/").status_code != 200


@pytest.mark.service
@pytest.mark.asvs("7.3.2")
def test_a_session_lasts_14_days_from_signing_in_and_is_removed_then(people, client):
    """session | [...] | 14 days from signing in."""
    client.post("/accounts/login/", {"login": "ada", "password": "correct horse 42"})
    row = Session.objects.get()
    assert abs(row.expire_date - SYSTEM.now() - 14 * DAY) < timedelta(minutes=5)
    before = row.expire_date
    client.get("/me/")
    assert Session.objects.get().expire_date == before, "looking at a page makes it no longer"
    assert old_sessions(before) == 0
    assert old_sessions(before + DAY) == 1


@pytest.mark.service
@pytest.mark.asvs("7.4.2")
def test_a_session_does_not_go_on_when_the_account_is_switched_on_again(people, admin_client):
    """Staff end all sessions of a person by deactivating the account."""
    ada = people["ada"]
    here, page = signed_in(ada), f"/admin/accounts/user/{ada.pk}/change/"
    for active in (None, "on"):
        form = controls_of(admin_client.get(page))
        assert admin_client.post(page, as_sent(form, is_active=active)).status_code == 302
    ada.refresh_from_db()
    assert ada.is_active
    assert here.get("/me/").status_code == 302
    assert signed_in(ada).get("/me/").status_code == 200


def test_only_switching_an_account_off_looks_at_all_sessions(people, monkeypatch, django_user_model):
    looked, ada = [], people["ada"]
    monkeypatch.setattr("accounts.sessions.end_sessions", looked.append)
    ada.save()
    ada.is_active = False
    ada.save(update_fields=["last_login"])
    assert looked == []
    ada.save()
    assert looked == [ada]
    ada.save()
    ada.is_active = True
    ada.save()
    django_user_model.objects.create_user("new", "new@example.org", "correct horse 42", is_active=False)
    assert looked == [ada]


def test_a_session_ends_when_staff_reset_the_password(people, admin_client):
    """Staff end all sessions of a person [...] by resetting its password in the admin."""
    here, new = signed_in(people["ada"]), "a long enough phrase 9"
    page = f"/admin/accounts/user/{people['ada'].pk}/password/"
    answer = admin_client.post(page, {"password1": new, "password2": new, "usable_password": "true"})
    assert answer.status_code == 302
    assert here.get("/me/").status_code == 302


@pytest.mark.service
def test_which_sessions_have_the_page_open_is_forgotten_when_the_turn_ends(used, root):
    """which sessions of the operator have the robot's page open | the server | database | until the turn ends."""
    turn = Turn.objects.get(ended_at=None)
    TurnSession.objects.create(turn=turn, session="a" * 32, last_seen=SYSTEM.now())
    root.post("/admin/queueing/turn/", {"action": "end", "_selected_action": [turn.pk]})
    assert not TurnSession.objects.exists()


@pytest.mark.service
def test_a_picture_is_removed_after_30_days_once_no_entry_shows_it(used, root, settings):
    """pictures that nothing refers to: 30 days (`FARHAND_FRAME_KEEP_DAYS`)."""
    entry = Entry.objects.get(author=used["ada"])
    shown, later = entry.frame, SYSTEM.now() + 31 * DAY
    for frame in Frame.objects.all():
        path = Path(settings.MEDIA_ROOT) / frame.file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"picture")
    assert settings.FRAME_KEEP_DAYS == 30
    assert old_frames(later - 2 * DAY) == 0
    assert old_frames(later) > 0
    assert list(Frame.objects.all()) == [shown]
    delete(root, entry)
    assert old_frames(later) == 1
    assert not (Path(settings.MEDIA_ROOT) / shown.file).exists()


@pytest.mark.service
def test_a_picture_that_its_author_replaced_is_kept_no_longer(used):
    """pictures that nothing refers to: 30 days."""
    entry = Entry.objects.get(author=used["ada"])
    first, other = entry.turn.grant.frames.order_by("pk")
    client = signed_in(used["ada"])
    for chosen in (other.pk, ""):
        page = client.post(entry.turn.get_absolute_url(), {"text": "Another one.", "frame": chosen})
        assert page.status_code == 302
        first.refresh_from_db()
        other.refresh_from_db()
        assert (first.kept, other.kept) == (False, chosen == other.pk)


def test_cookie_hash_and_address_of_a_guest_are_read_by_staff_alone(used, root):
    """jobs of guests [...] | the page of a job everybody who has its address; hash and address only staff."""
    job = Job.objects.get(user=None)
    for visitor in (Client(), signed_in(used["ada"])):
        assert visitor.get(job.get_absolute_url()).status_code == 200
        shown = told(visitor)
        assert job.guest not in shown
        assert job.account.network not in shown
    assert job.guest in root.get(f"/admin/queueing/job/{job.pk}/change/").content.decode()
    assert job.account.network in root.get(f"/admin/queueing/account/{job.account_id}/change/").content.decode()


def test_answers_are_kept_until_staff_delete_them_and_read_by_staff_who_may(used, root):
    """answers to the survey | staff who may see them; they are stored with the turn | until they are deleted."""
    response = SurveyResponse.objects.exclude(turn=None).get()
    assert "=chess" in root.get(f"/admin/operatorlog/surveyresponse/{response.pk}/change/").content.decode()
    for visitor in (Client(), signed_in(used["bob"]), signed_in(used["ada"])):
        assert "=chess" not in told(visitor)
        assert visitor.get("/survey/results.csv").status_code == 403
    delete(root, response)
    assert not SurveyAnswer.objects.filter(value="=chess").exists()
    assert Turn.objects.filter(pk=response.turn_id).exists()


def test_answers_after_a_job_name_the_robot_and_the_day_and_not_the_job(used):
    """answers to the survey after a job [...] are stored with the robot and the day, not with the job."""
    one = SurveyResponse.objects.get(turn=None)
    assert one.robot.slug == "irat"
    assert (one.at.hour, one.at.minute, one.at.second, one.at.microsecond) == (0, 0, 0, 0)
    assert {f.name for f in SurveyResponse._meta.fields} == {"id", "turn", "robot", "at"}


def test_a_program_is_read_by_its_author_and_staff_until_it_is_approved(used, root):
    """programs | the person, staff who may see them, and everybody after staff have approved a shared one."""
    mine = Program.objects.get(author=used["ada"])
    Program.objects.filter(pk=mine.pk).update(approved=False)
    page = "/robots/pa10/programs/"
    names = lambda client: [one["name"] for one in client.get(page).json()["programs"]]  # noqa: E731
    assert mine.name in names(signed_in(used["ada"]))
    assert mine.name not in names(signed_in(used["bob"]))
    root.post("/admin/robots/program/", {"action": "take_in", "_selected_action": [mine.pk]})
    assert mine.name in names(Client())
    delete(root, mine)
    assert mine.name not in names(signed_in(used["ada"]))
