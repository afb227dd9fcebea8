"""The texts of mails, and the link that a demo shows on its page."""

import re

import pytest
from django.core import mail
from django.core.cache import cache

pytestmark = pytest.mark.django_db
CONSOLE = "django.core.mail.backends.console.EmailBackend"
LINK = re.compile(r"/accounts/confirm-email/[^\"\s]+/")


@pytest.fixture(autouse=True)
def no_count():
    """Attempts of other tests do not count."""
    cache.clear()


def sign_up(client, name="newone", email="new@example.org"):
    data = {"username": name, "email": email, "password1": "correct horse 42"}
    return client.post("/accounts/signup/", data, follow=True).content.decode()


@pytest.fixture
def demo(settings, capfd):
    settings.MAIL_IN_BACKGROUND = False
    settings.EMAIL_BACKEND = CONSOLE


def test_mails_greet_from_the_site_by_its_name(client, settings, robot, people):
    settings.MAIL_IN_BACKGROUND = False
    settings.SITE_NAME = "The Sand Museum"
    sign_up(client)
    client.post("/accounts/password/reset/", {"email": "new@example.org"})
    sign_up(type(client)(), "third", "ada@example.org")
    assert len(mail.outbox) == 3
    for one in mail.outbox:
        assert "Hello from The Sand Museum!" in one.body
        assert "from testserver" not in one.body
        assert "on testserver" not in one.body
    assert LINK.search(mail.outbox[0].body)


def test_a_demo_shows_the_link_on_the_page_after_signing_up(client, demo, robot):
    html = sign_up(client)
    link = LINK.search(html)[0]
    assert LINK.search(type(client)().get("/accounts/confirm-email/").content.decode()) is None, "another session"
    assert client.post(link).status_code == 302
    assert LINK.search(client.get("/accounts/confirm-email/").content.decode()) is None, "once confirmed it is gone"


def test_no_old_link_stands_beside_a_new_sign_up(client, demo, robot, people):
    sign_up(client)
    assert LINK.search(sign_up(client, "third", "ada@example.org")) is None


TERMINAL = "This is a demo: your mail is in the terminal"


def test_a_demo_tells_where_the_mail_for_a_new_password_is_and_shows_its_link_to_nobody(client, demo, people, capfd):
    """A person who asks for it has not yet shown that the account is theirs."""
    for email in ("ada@example.org", "nobody@example.org"):
        html = client.post("/accounts/password/reset/", {"email": email}, follow=True).content.decode()
        assert TERMINAL in html
        assert "/password/reset/key/" not in html
    assert "/accounts/password/reset/key/" in capfd.readouterr().out


def test_a_demo_tells_where_the_mail_is_that_has_no_link(client, demo, people):
    assert TERMINAL in sign_up(client, "third", "ada@example.org")


def test_a_demo_shows_the_link_of_an_address_that_is_added(client, demo, people):
    client.force_login(people["ada"])
    html = client.post("/accounts/email/", {"action_add": "", "email": "new@example.org"}, follow=True).content.decode()
    assert LINK.search(html)


def test_with_a_mail_server_nothing_is_said_of_a_terminal(client, people):
    html = client.post("/accounts/password/reset/", {"email": "ada@example.org"}, follow=True).content.decode()
    assert "We have sent you an e-mail." in html
    assert "terminal" not in html


@pytest.mark.asvs("6.4.3")
@pytest.mark.parametrize(("public", "backend"), [(True, CONSOLE), (False, "django.core.mail.backends.locmem.EmailBackend"), (False, "django.core.mail.backends.smtp.EmailBackend")])  # fmt: skip
def test_nobody_else_shows_it(client, settings, demo, robot, public, backend, monkeypatch):
    from accounts import adapter

    settings.PUBLIC, settings.EMAIL_BACKEND = public, backend
    monkeypatch.setattr(adapter, "_send", lambda message: None)
    settings.MAIL_IN_BACKGROUND = True  # no mail server is asked
    html = sign_up(client)
    assert LINK.search(html) is None
    assert "confirmation_link" not in client.session


ADDRESS = re.compile(r"https?://[^\s]+")


@pytest.mark.parametrize("host", ["testserver:9999", "localhost:81", "127.0.0.1", "[::1]:4"])
def test_links_lead_to_the_configured_site_whatever_host_the_request_names(client, settings, robot, people, host):
    settings.MAIL_IN_BACKGROUND, settings.SITE_ADDRESS = False, "https://robots.example.org:8443"
    sender = type(client)(headers={"host": host})
    sign_up(sender)
    sign_up(type(client)(headers={"host": host}), "third", "ada@example.org")
    for email in ("new@example.org", "nobody@example.org"):
        sender.post("/accounts/password/reset/", {"email": email})
    assert len(mail.outbox) == 4
    for one in mail.outbox:
        text = one.subject + one.body
        assert ADDRESS.findall(text)
        assert all(link.startswith("https://robots.example.org:8443/") for link in ADDRESS.findall(text))
        assert host not in text
    reset = next(link for one in mail.outbox for link in ADDRESS.findall(one.body) if "/reset/key/" in link)
    assert client.get(reset.removeprefix(settings.SITE_ADDRESS), follow=True).status_code == 200
