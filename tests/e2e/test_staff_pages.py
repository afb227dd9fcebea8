"""Pages of staff: Stop is in view, what is well is not red, entries show their pictures, and answers can be read."""

from datetime import timedelta

import pytest

from operatorlog import services as log
from operatorlog.models import SurveyAnswer, SurveyQuestion
from portal.keep.seeding import add_robot
from queueing import services as queue
from robots.kit.clock import SYSTEM
from robots.models import Command, Robot
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.test_axe import DARK, LIGHT
from tests.services.in_use import job_done

LONG = "Pleasing and easy to use, but the letters of the buttons are small on the telephone of my grandmother"
INSIDE = "e => { const r = e.getBoundingClientRect(); return r.top >= 0 && r.bottom <= innerHeight && r.right <= innerWidth }"
TEXTS = """() => [...document.querySelectorAll('.plot')].map((plot) => {
  const place = (e) => e.getBoundingClientRect(), all = place(plot);
  const texts = [...plot.querySelectorAll('text')].filter((t) => getComputedStyle(t).display !== 'none');
  const outside = texts.filter((t) => place(t).left < all.left - 1 || place(t).right > all.right + 1 || place(t).bottom > all.bottom + 1);
  const over = texts.filter((t, n) => texts.slice(0, n).some((o) => place(o).left < place(t).right && place(t).left < place(o).right && place(o).top + 2 < place(t).bottom && place(t).top + 2 < place(o).bottom));
  return [...outside, ...over].map((t) => t.textContent);
})"""
OUT = """() => [...document.querySelectorAll('.farhand-actions *, .farhand-queue li')].filter((e) => e.getBoundingClientRect().right > innerWidth + 1).map((e) => e.outerHTML)"""
OVERLAP = """() => [...document.querySelectorAll('.bars tr')].flatMap((row) => {
  const boxes = [...row.children].map((cell) => { const range = document.createRange(); range.selectNodeContents(cell); return range.getBoundingClientRect(); });
  return boxes.slice(1).map((box, n) => boxes[n].right - box.left);
}).filter((over) => over > 0.5)"""


@pytest.fixture
def staff(portal, visitor):
    """Open browsers of a superuser, one in each look."""
    root = portal.person("root", is_staff=True, is_superuser=True)

    def make():
        for look in (LIGHT, DARK):
            one = session(visitor(**look), root)
            yield one

    return make


def test_stop_is_in_view_at_the_top_of_the_robots_page_in_the_admin(portal, staff):
    Robot.objects.filter(pk=portal.robot.pk).update(stop_latched=True, reason="It was stopped.")
    for one in staff():
        one.page.goto(f"/admin/robots/robot/{portal.robot.pk}/change/")
        stop = one.page.get_by_role("button", name="Stop", exact=True)
        assert stop.evaluate(INSIDE)
        stop.click()
        one.page.get_by_text("Stop was sent.").wait_for()
        assert one.page.get_by_role("button", name="Stop", exact=True).evaluate(INSIDE), "with a message above it"
        one.axe("the robot in the admin")


def test_lists_of_the_admin_show_red_only_what_is_bad_and_pictures_with_words(portal, staff):
    entry = portal.entry(portal.person("ada", "mercury"), "mercury")
    Robot.objects.exclude(pk=portal.robot.pk).update(stop_latched=True)
    for one in staff():
        one.page.goto("/admin/robots/robot/")
        cells = {
            c.inner_text(): c.evaluate("e => getComputedStyle(e.firstElementChild || e).color")
            for c in one.page.locator(".field-stop").all()
        }
        assert set(cells) == {"Stopped", "-"}
        assert cells["Stopped"] != cells["-"]
        one.axe("robots")
        one.page.goto("/admin/accounts/user/")
        assert (
            one.page.locator("td img[src*='icon-no']").first.evaluate("e => getComputedStyle(e).filter")
            == "grayscale(1)"
        )
        for address in (
            "/admin/operatorlog/entry/",
            f"/admin/operatorlog/entry/{entry.pk}/change/",
            "/admin/robots/frame/",
        ):
            one.page.goto(address)
            picture = one.page.locator("img.farhand-thumbnail").first
            assert picture.get_attribute("alt").startswith("Picture "), address
            assert picture.get_attribute("loading") == "lazy"
            picture.scroll_into_view_if_needed()
            one.page.wait_for_function("e => e.naturalWidth > 0", arg=picture.element_handle())
            one.axe(address)


def test_no_label_of_the_surveys_results_lies_over_a_number(portal, staff):
    choice = SurveyQuestion.objects.create(
        prompt="Layout?", kind="choice", options=f"{LONG}\nYes\n{'w' * 200}", position=9
    )
    for n in range(12):
        turn = portal.end(portal.drive(portal.person(f"p{n:02}", "mercury"), "mercury"))
        log.answer_survey(turn, turn.user, {choice.pk: (LONG, "Yes", "w" * 200)[n % 3]}, SYSTEM.now())
    assert SurveyAnswer.objects.count() == 12
    for one in staff():
        one.page.goto("/survey/results/")
        assert one.page.locator(".bars").count() >= 3
        assert one.page.evaluate(OVERLAP) == []
        assert one.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        one.axe("results")


def test_no_number_of_the_statistics_lies_over_another(portal, staff):
    irat, ada, now = add_robot("irat"), portal.person("ada"), SYSTEM.now()
    for n in range(12):
        job = job_done(irat, ada, now - timedelta(minutes=100 * n + 1))
        told = {"battery": 6.5 + 0.1 * n, "experiences": 820.0 * n, "driven": float(n)}
        Command.objects.filter(grant__job_run__job=job).update(result={"channels": {"began": told, "ended": told}})
    for one in staff():
        one.page.goto("/robots/irat/statistics/")
        assert one.page.locator(".plot").count() == 3
        assert one.page.evaluate(TEXTS) == [[], [], []]
        assert one.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("look", [LIGHT, DARK], ids=["wide", "narrow"])
def test_nothing_of_a_robots_or_a_queues_page_sticks_out(portal, visitor, look):
    """Also of a robot with settings by staff, each with a field."""
    one = session(visitor(**look), portal.person("root", is_staff=True, is_superuser=True))
    queue.join(portal.robots["pa10"], portal.person("ada", "pa10"), SYSTEM.now())
    arm = portal.robots["pa10"]
    for address in (f"robots/robot/{arm.pk}", f"queueing/queue/{arm.queue_link.queue_id}"):
        one.page.goto(f"/admin/{address}/change/")
        assert one.page.evaluate(OUT) == [], address
        one.axe(address)
