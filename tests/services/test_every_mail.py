"""Each mail that the portal sends, sent by its real way: each link in it is absolute, of the configured site, and opens."""

import re
from pathlib import Path

import allauth
import pytest
from allauth.account import app_settings
from allauth.account.models import EmailAddress
from django.conf import settings
from django.core import mail
from django.test import Client

from accounts.adapter import AccountAdapter
from accounts.turn_mails import choose_mail
from portal.folders import ROOT, TEMPLATES_DIR
from portal.web.push.mailing import mail_offers
from queueing import services as queue
from queueing.models import Job, QueueRobot
from queueing.services import Asker, ask
from queueing.tasks import queue_tick
from robots.models import Command
from robots.states import CommandState
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
SITE = "https://robots.example.org:8443"
LINK = re.compile(r"\w+://[^\s<>\"']+")
RELATIVE = re.compile(r"(?<![\w:/.<])/[a-z][\w/-]*|(?:href|src)=[\"']?/", re.IGNORECASE)
SECRET = "correct horse 42"


@pytest.fixture
def named(settings, monkeypatch):
    """Return the names of the templates of which mails were made, while these are sent."""
    settings.SITE_ADDRESS, settings.MAIL_IN_BACKGROUND = SITE, False
    found = set()
    render = AccountAdapter.render_mail

    def noted(self, prefix, *args, **kwargs):
        found.add(prefix.rpartition("/")[2])
        return render(self, prefix, *args, **kwargs)

    monkeypatch.setattr(AccountAdapter, "render_mail", noted)
    return found


def sign_up(email, name="newone"):
    data = {"username": name, "email": email, "password1": SECRET}
    assert Client().post("/accounts/signup/", data).status_code == 302


def confirmation(people, shuttle, clock):
    sign_up("new@example.org")


def another_address(people, shuttle, clock):
    EmailAddress.objects.create(user=people["ada"], email="ada@example.org", verified=True, primary=True)
    signed_in = Client()
    signed_in.post("/accounts/login/", {"login": "ada", "password": SECRET})
    assert signed_in.post("/accounts/email/", {"email": "second@example.org", "action_add": ""}).status_code == 302


def known_address(people, shuttle, clock):
    EmailAddress.objects.create(user=people["ada"], email="ada@example.org", verified=True, primary=True)
    sign_up("ada@example.org")


def new_password(people, shuttle, clock):
    EmailAddress.objects.create(user=people["ada"], email="ada@example.org", verified=True, primary=True)
    Client().post("/accounts/password/reset/", {"email": "ada@example.org"})


def new_password_of_nobody(people, shuttle, clock):
    Client().post("/accounts/password/reset/", {"email": "nobody@example.org"})


def job_end(people, shuttle, clock):
    """Let a job run to its end; the tick, a task of Celery's worker, sends the mail, and there is no request."""
    ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now(), mail=True)
    for _ in range(2):
        queue_tick.apply().get()
        clock.go(1)
        for command in Command.objects.select_related("robot", "grant").filter(ended_at=None):
            rows.finish(command, CommandState.COMPLETED, clock.now())
    queue_tick.apply().get()
    assert Job.objects.get().state == "done"


def turn(people, shuttle, clock):
    """Offer ada, who has chosen so, a robot; the task of a worker sends the mail."""
    EmailAddress.objects.create(user=people["ada"], email="ada@example.org", verified=True, primary=True)
    choose_mail(people["ada"], True)
    QueueRobot.objects.update(offers_turns=True)
    queue.join(shuttle, people["ada"], clock.now())
    queue.tick(clock.now())
    assert mail_offers(clock) == 1


ALLAUTHS = {
    "email_confirmation_signup": confirmation, "email_confirmation": another_address,
    "account_already_exists": known_address, "password_reset_key": new_password,
    "unknown_account": new_password_of_nobody,
}  # fmt: skip
OWN = {"job_end": job_end, "turn": turn}


@pytest.mark.parametrize(("name", "cause"), (ALLAUTHS | OWN).items(), ids=ALLAUTHS | OWN)
def test_each_link_of_each_mail_is_absolute_and_opens(shuttle, people, clock, trusted, named, monkeypatch, name, cause):
    monkeypatch.setattr("queueing.tasks.wall_clock", lambda: trusted)
    cause(people, shuttle, clock)
    assert named == ({name} & ALLAUTHS.keys())
    (message,) = mail.outbox
    texts = [message.body, *(part.content for part in getattr(message, "alternatives", ()))]
    for text in texts:
        links = LINK.findall(text)
        assert links, "a mail says where it is from"
        assert not RELATIVE.search(LINK.sub("", text)), "a link without a site"
        assert "testserver" not in text
        for link in links:
            assert link.startswith(f"{SITE}/")
            answer = Client().get(link.removeprefix(SITE), follow=True)
            assert answer.status_code == 200, link
    assert "testserver" not in message.subject


def sent_never():
    """Return the mails of allauth's that these settings never send."""
    assert not app_settings.EMAIL_NOTIFICATIONS
    assert not app_settings.LOGIN_BY_CODE_ENABLED
    assert not app_settings.PASSWORD_RESET_BY_CODE_ENABLED
    assert not app_settings.EMAIL_VERIFICATION_BY_CODE_ENABLED
    notices = {"email_changed", "email_confirm", "email_deleted", "password_changed", "password_reset", "password_set"}
    return notices | {"login_code", "password_reset_code"}


def test_a_mail_that_is_new_is_tested_above():
    """A new template, also of a new allauth, and new code that sends mails need a way to be sent here."""
    assert {app for app in settings.INSTALLED_APPS if app.startswith("allauth.")} == {"allauth.account"}
    theirs = Path(allauth.__file__).parent / "templates" / "account"
    files = {path.name for folder in (theirs, TEMPLATES_DIR) for path in Path(folder).rglob("email/*")}
    made = {re.sub(r"_(message|subject)\.(txt|html)$", "", name) for name in files}
    assert made - {"base", "base_notification.txt"} == ALLAUTHS.keys() | sent_never()
    sends = re.compile(r"\b(EmailMessage|EmailMultiAlternatives|send_mail|send_mass_mail|mail_admins|mail_managers|email_user|AdminEmailHandler)\(")  # fmt: skip
    apps = ("accounts", "operatorlog", "portal", "queueing", "robots", "workers")
    code = [path for app in apps for path in sorted(Path(ROOT, app).rglob("*.py"))]
    found = {(path.relative_to(ROOT).as_posix(), one) for path in code for one in sends.findall(path.read_text())}
    assert found == {
        ("queueing/jobs/running.py", "EmailMessage"),
        ("accounts/adapter.py", "send_mail"),
        ("portal/web/alerts/sending.py", "EmailMessage"),
        ("portal/web/push/mailing.py", "EmailMessage"),
    }
