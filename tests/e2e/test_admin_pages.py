"""axe finds nothing on any page of the admin's models, and none scrolls sideways; the pages come from the admin's registry."""

from types import SimpleNamespace

import pytest
from django.urls import reverse

from operatorlog.models import Find, Piece, Round
from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Incident
from robots.services.incidents import AS_IT_IS
from tests.conftest import at_length
from tests.e2e.conftest import session
from tests.e2e.test_axe import ENGLISH, GERMAN, LIGHT, REST, looked_at, named, seen, spoken
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


@pytest.mark.parametrize("looks", [spoken("de-DE", LIGHT)], ids=named)
def test_on_a_wide_screen_every_column_is_in_view_and_the_cells_of_a_row_end_together(portal, staff, looks):
    Incident.objects.update(remedy=AS_IT_IS, closed_at=SYSTEM.now())
    find = Find.objects.first()
    piece, _ = Piece.objects.get_or_create(round=find.round, name="bag")
    Find.objects.filter(pk=find.pk).update(state=Find.State.CONFIRMED, piece=piece)
    for page in admin_pages(portal.root):
        if page.count("/") == 4:
            staff.page.goto(page)
            hidden = staff.page.locator(".results").evaluate("one => one.scrollWidth - one.clientWidth")
            assert hidden == 0, f"{page}: {hidden} px of the table are out of sight"
    staff.page.goto(f"/robots/{find.round.robot.slug}/finds/")
    row = staff.page.locator(".finds tbody tr").first
    ends = row.locator("> *").evaluate_all("all => [...new Set(all.map((one) => one.getBoundingClientRect().bottom))]")
    assert len(ends) == 1
