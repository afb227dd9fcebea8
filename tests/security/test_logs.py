"""The content of the security log, and what it never contains."""

import logging
import sys

import pytest
from allauth.account.models import EmailAddress

from portal.logs.lines import Line

FORM = "%(asctime)s %(levelname)s %(name)s: %(message)s"


def record(text, *args, **more):
    return logging.LogRecord("farhand", logging.WARNING, __file__, 1, text, args, **{"exc_info": None, **more})


@pytest.mark.asvs("16.2.2", "16.2.4", "16.2.1")
def test_a_line_says_when_in_utc():
    made = record("it is so")
    made.created, made.msecs = 1_800_000_000.25, 250.0
    assert Line(FORM).format(made) == "2027-01-15T08:00:00.250Z WARNING farhand: it is so"


@pytest.mark.asvs("16.4.1", "1.3.10")
@pytest.mark.parametrize("text", ["a\nERROR root: forged", "a\r\nb", "a\x1b[2Jb", "\u2028b", "%s%n{0.__class__}"])
def test_what_a_stranger_wrote_begins_no_line(text):
    line = Line(FORM).format(record("refused: %s", text))
    assert len(line.splitlines()) == 1
    assert line.isprintable()


@pytest.mark.asvs("16.3.4")
def test_a_traceback_keeps_its_lines():
    try:
        raise ValueError("inside")
    except ValueError:
        text = Line(FORM).format(record("failed", exc_info=sys.exc_info()))
    assert "ValueError: inside" in text.splitlines()[-1]


@pytest.mark.django_db
@pytest.mark.asvs("16.3.1", "16.2.5")
def test_signing_in_failing_and_out_are_told_without_what_was_typed(people, client, caplog):
    EmailAddress.objects.create(user=people["ada"], email="ada@example.org", verified=True, primary=True)
    with caplog.at_level(logging.INFO, "farhand.security"):
        client.post("/accounts/login/", {"login": "hunter2 typed here", "password": "a wrong one 77"})
        client.post("/accounts/login/", {"login": "ada", "password": "correct horse 42"})
        key = client.session.session_key
        client.post("/accounts/logout/")
    told = [r.getMessage() for r in caplog.records if r.name == "farhand.security"]
    assert [t.split(":")[0].split(" from")[0] for t in told] == ["sign-in failed", "signed in", "signed out"]
    assert f"account {people['ada'].pk} from 127.0.0.1" in told[1]
    for secret in ("hunter2", "a wrong one 77", "correct horse 42", key):
        assert secret not in caplog.text


@pytest.mark.django_db
@pytest.mark.asvs("16.3.2", "16.3.3")
def test_a_refused_request_is_told(people, client, caplog):
    client.force_login(people["ada"])
    with caplog.at_level(logging.INFO, "farhand.security"):
        assert client.get("/survey/results/").status_code == 403
    assert f"refused with 403: GET /survey/results/, account {people['ada'].pk} from 127.0.0.1" in caplog.text
