"""Every page is reached by links alone, from the first page or from the first page of staff."""

import re
from urllib.parse import unquote, urldefrag

import pytest
from django.urls import Resolver404, resolve

from tests.e2e.pages import OWN, PUBLIC, STAFF, known
from tests.services.admin_pages import admin_pages
from tests.services.browsers import signed_in

pytestmark = [pytest.mark.service, pytest.mark.django_db]
LINK = re.compile(r"""<a\s[^>]*?href=["']([^"']+)["']""")
ROWS = {"turn": 1, "job": "a", "recording": "a", "robot": 1, "practice": "twin"}
# reached by a mail, by a form that was sent, or by a refusal
OTHERWISE = {
    "job", "recording",  # a recording without a file is in no list
    "account_reset_password_done", "account_reset_password_from_key", "account_reset_password_from_key_done",
    "account_email_verification_sent", "account_confirm_email", "account_inactive", "account_reauthenticate",
    "account_logout",  # a button of every page
    "embed-robot", "embed-recording",  # in other sites' pages
}  # fmt: skip
MOST = 900


def kind(address):
    """Return what tells pages apart: the name of the address in the table; of the admin's pages, with the model."""
    try:
        found = resolve(address)
    except Resolver404:
        return None
    return found.view_name


def reached(browser, first):
    """Follow links from there, a few pages of each kind; return the kinds of pages that answered."""
    todo, done, count = [first], {first}, {}
    while todo and len(done) < MOST:
        address = todo.pop(0)
        name = kind(address)
        if name is None or count.get(name, 0) >= 4:
            continue
        answer = browser.get(address, follow=True)
        if answer.status_code != 200 or "text/html" not in answer.headers.get("Content-Type", ""):
            continue
        count[name] = count.get(name, 0) + 1
        for link in LINK.findall(answer.text):
            path = urldefrag(unquote(link).replace("&amp;", "&"))[0].partition("?")[0]
            if path.startswith("/") and path not in done:
                done.add(path)
                todo.append(path)
    return set(count)


def kinds(addresses):
    return {kind(address) for address in addresses} - {None}


def test_each_page_is_linked(used):
    visitor = reached(signed_in(None), "/")
    assert kinds(known(PUBLIC, **ROWS).values()) - OTHERWISE - visitor == set()
    person = reached(signed_in(used["eve"]), "/")
    assert kinds(known(OWN, new="pa10").values()) - OTHERWISE - person == set()


def test_each_page_of_staff_is_linked(used):
    staff = reached(signed_in(used["root"]), "/admin/")
    assert kinds(known(STAFF, **ROWS).values()) - staff == set()
    wanted = kinds(admin_pages(used["root"]))
    assert wanted - staff == set()
