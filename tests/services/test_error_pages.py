"""Error pages: each is drawn before any middleware has run, and a wrong Host costs one line and no query."""

import asyncio
import logging
import re

import pytest
from asgiref.testing import ApplicationCommunicator
from django.core.exceptions import PermissionDenied
from django.db import OperationalError
from django.http import Http404
from django.test import Client, RequestFactory

from portal.web.pages import errors
from tests.services.browsers import signed_in

pytestmark = [pytest.mark.service, pytest.mark.django_db]
PLACES = ["/", "/log/", "/admin/", "/static/portal/icon.svg", "/livez", "/nowhere/"]
WRONG = [
    "evil.example",
    "testserver,testserver",
    "testserver, evil.example",
    "a b",
    "[::1",
    "testserver:port",
    "",
    "x" * 9000,
]


@pytest.mark.asvs("16.5.1")
@pytest.mark.parametrize("host", WRONG)
def test_a_wrong_host_is_400_in_words_without_traceback_or_query(robot, caplog, host, django_assert_num_queries):
    for method, path in [("get", path) for path in PLACES] + [("post", "/accounts/login/")]:
        caplog.clear()
        with caplog.at_level(logging.INFO), django_assert_num_queries(0):
            answer = getattr(Client(headers={"host": host}), method)(path)
        assert answer.status_code == 400
        assert "Host" in answer.text
        assert len(answer.content) < 2000
        assert "evil" not in answer.text
        assert not re.search("(src|href)=", answer.text), "a browser asks for nothing else of that host"
        [line] = [r.getMessage() for r in caplog.records]
        assert len(line) < 400
        assert not any(record.exc_info for record in caplog.records)


def test_two_host_headers_are_400_on_the_wire(robot, caplog):
    from portal.asgi import application

    async def asked():
        scope = {
            "type": "http", "method": "GET", "path": "/livez", "raw_path": b"/livez", "query_string": b"",
            "headers": [(b"host", b"testserver"), (b"host", b"testserver")], "client": ("127.0.0.1", 1),
            "server": ("127.0.0.1", 80), "scheme": "http", "http_version": "1.1", "asgi": {"version": "3.0"},
        }  # fmt: skip
        one = ApplicationCommunicator(application, scope)
        await one.send_input({"type": "http.request", "body": b""})
        told = await one.receive_output(60)
        await one.wait(60)
        return told

    assert asyncio.run(asked())["status"] == 400
    assert not any(record.exc_info for record in caplog.records)


def test_the_names_of_this_portal_are_served(robot):
    for host in ("testserver", "localhost:8000", "TESTSERVER", "[::1]:8001"):
        assert Client(headers={"host": host}).get("/livez").status_code == 200


@pytest.mark.parametrize("status, draw", [
    (400, lambda request: errors.bad_request(request, ValueError())),
    (403, lambda request: errors.forbidden(request, PermissionDenied())),
    (403, lambda request: errors.csrf_failure(request, "none")),
    (404, lambda request: errors.not_found(request, Http404())),
    (405, lambda request: errors.not_allowed(request, ["GET"])),
    (429, errors.too_many),
    (500, errors.server_error),
    (503, lambda request: errors.software_missing(request, "Mercury")),
])  # fmt: skip
def test_each_page_is_drawn_where_no_middleware_has_run(robot, status, draw):
    answer = draw(RequestFactory().get("/nowhere/"))
    assert answer.status_code == status
    assert "<h1>" in answer.text
    assert 'href="/"' in answer.text


def test_the_database_is_away_before_any_middleware_has_run(robot):
    try:
        raise OperationalError("gone")
    except OperationalError:
        answer = errors.server_error(RequestFactory().get("/"))
    assert (answer.status_code, answer["Retry-After"]) == (503, "10")


@pytest.mark.parametrize("method, path", [("TRACE", "/"), ("PUT", "/log/"), ("POST", "/robots/mercury/statistics/"), ("GET", "/robots/mercury/stream-code/"), ("DELETE", "/robots/mercury/jobs/")])  # fmt: skip
def test_a_method_that_does_not_fit_is_told_in_words(robot, people, method, path):
    client = signed_in(people["ada"])
    answer = client.generic(method, path)
    assert answer.status_code == 405
    assert "GET" in answer["Allow"] or "POST" in answer["Allow"]
    assert "<h1>" in answer.text


def test_too_many_attempts_are_told_in_the_portals_own_words(robot, people, client, one_count):
    for _ in range(11):
        answer = client.post("/accounts/signup/", {})
    assert answer.status_code == 429
    assert "wait" in answer.text
    assert "<h1>" in answer.text


def test_a_form_of_very_many_fields_is_400_without_traceback(robot, client, caplog):
    for answer in (
        client.post("/accounts/login/", {f"a{n}": "" for n in range(1200)}),
        client.get("/log/?" + "a=&" * 1200),
    ):
        assert answer.status_code == 400
        assert not any(record.exc_info for record in caplog.records)
