"""axe finds nothing on any page of the admin's models, and none scrolls sideways; the pages come from the admin's registry."""

from types import SimpleNamespace

import pytest
from django.urls import reverse

from operatorlog.models import Round
from robots import bus
from robots.kit.clock import SYSTEM
from tests.conftest import at_length
from tests.e2e.conftest import session
from tests.e2e.test_axe import ENGLISH, GERMAN, REST, looked_at, named, seen
from tests.services.admin_pages import admin_pages, lists_that_delete
from tests.services.in_use import in_use

# in the gate on a phone in German, where least has room; at length in each look
EACH_LOOK = pytest.mark.parametrize("looks", [GERMAN, *map(at_length, [ENGLISH, *REST])], ids=named)
# Django lets a table of rows scroll by itself; what asks or says something fits
SIDEWAYS = "() => document.documentElement.scrollWidth > innerWidth ? [`the page is ${document.documentElement.scrollWidth} px wide`] : []"
OTHERS = ["/admin/robots/", "/admin/password_change/"]


@pytest.fixture
def portal(transactional_db, redis_server, house, robot, people, django_user_model):
    """The web process over the rows of a portal in use."""
    if house.robot(robot.slug) is None:
        bus.connection().flushall()
    people["root"] = django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")
    in_use(robot, people, SYSTEM.now())
    return SimpleNamespace(url=house.web_process().url, root=people["root"])


@pytest.fixture
def staff(portal, visitor, looks):
    """A browser of the superuser in these looks."""
    one = session(visitor(**looks[0]), portal.root)
    one.allowed = ("404",)  # no picture was stored
    return one


@EACH_LOOK
def test_lists_and_forms(portal, staff, looks):
    pages = [page for page in admin_pages(portal.root) if not page.endswith(("/history/", "/delete/"))]
    asking = [
        f"/admin/accounts/user/{portal.root.pk}/password/",
        reverse("admin:operatorlog_round_bury", args=[Round.objects.get(ended_at=None).pk]),
    ]
    looked_at(staff, [*pages, *OTHERS, *asking], looks, over=SIDEWAYS)


@pytest.mark.parametrize("looks", [*map(at_length, [ENGLISH, GERMAN, *REST])], ids=named)
def test_histories_and_what_asks_before_rows_are_deleted(portal, staff, looks):
    pages = [page for page in admin_pages(portal.root) if page.endswith(("/history/", "/delete/"))]
    looked_at(staff, pages, looks, over=SIDEWAYS)
    for page in lists_that_delete(portal.root):
        staff.page.goto(page)
        staff.page.locator("input.action-select").first.check()
        staff.page.select_option("select[name=action]", "delete_selected")
        staff.page.locator("button[name=index]").first.click()
        staff.page.wait_for_selector("body.delete-selected-confirmation")
        seen(staff, looks, over=SIDEWAYS)
