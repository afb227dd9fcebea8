"""The page of a job follows it: nothing that can be pressed moves, and without news it asks ever less often."""

import pytest
from playwright.sync_api import expect

from queueing import services as queue
from queueing.models import Account
from queueing.models.jobs import Job, JobRun
from robots.kit.clock import SYSTEM
from robots.models import Command, Grant
from robots.states import GrantKind
from tests.e2e.bare import portal as portal
from tests.e2e.conftest import session
from tests.e2e.test_steady import SIZES

pytestmark = pytest.mark.timed

# each pause before the page is asked for once more, in ms
PAUSES = """window.pauses = []; const later = window.setTimeout;
window.setTimeout = (act, ms, ...more) => { if (ms >= 1000) window.pauses.push(ms); return later(act, ms, ...more); };"""


@pytest.fixture
def waiting(portal, visitor):
    """Give somebody who asked for a job its page, in a browser of their own."""

    def make(size=(1440, 900)):
        robot, now = portal.robots["mercury"], SYSTEM.now()
        one = visitor(viewport=dict(zip(("width", "height"), size, strict=True)))
        user = portal.person("ada", "mercury")
        line = queue.queue_of(robot)
        account = Account.objects.create(queue=line, user=user)
        one.job = Job.objects.create(
            queue=line, robot=robot, account=account, user=user, kind="up", asked_at=now, start_tag=0.0
        )
        session(one, user)
        one.page.add_init_script(PAUSES)
        one.page.goto(one.job.get_absolute_url())
        expect(one.page.get_by_role("button", name="Cancel this job")).to_be_visible()
        return one

    return make


@SIZES
def test_its_start_takes_nothing_from_under_a_finger(waiting, size):
    one = waiting(size)
    page, job = one.page, one.job
    cancel = page.get_by_role("button", name="Cancel this job")
    cancel.focus()
    box = cancel.bounding_box()
    page.mouse.move(box["x"] + 5, box["y"] + 5)
    page.mouse.down()
    now = SYSTEM.now()
    grant = Grant.objects.create(robot=job.robot, kind=GrantKind.JOB, holder=job.user, opened_at=now)
    JobRun.objects.create(job=job, grant=grant)
    Command.objects.create(
        grant=grant,
        robot=job.robot,
        client_seq=1,
        kind="up",
        epoch=1,
        state="acknowledged",
        created_at=now,
        deadline=now,
        progress={"share": 0.3},
    )
    Job.objects.update(state="running")
    expect(page.get_by_role("status").first).to_contain_text("Running")
    expect(page.locator("progress")).to_have_attribute("value", "0.3")
    assert cancel.bounding_box() == box
    expect(cancel).to_be_focused()
    one.axe("a job that runs")
    page.mouse.up()
    expect(page.get_by_role("status").first).not_to_contain_text("Running")
    job.refresh_from_db()
    assert job.cancel_asked_at or job.ended_at


def test_without_news_it_asks_ever_less_often(waiting):
    page = waiting().page
    for pause in (1000, 1400, 1960, 2744):  # as it says in `page/pending_parts.ts`; the page has other timers too
        page.wait_for_function("(pause) => window.pauses.some((ms) => Math.abs(ms - pause) < 1)", arg=pause)
