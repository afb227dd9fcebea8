"""Daily figures: which requests are page views, what is remembered of them, milestones and plots."""

from datetime import date, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.web.daily.hits import ALL, Hits, is_page, robot_of
from portal.web.daily.milestones import FIGURES, Day, milestones, totals
from portal.web.daily.views import number
from portal.web.statistics import plots

BROWSER = b"Mozilla/5.0 (X11; Linux x86_64; rv:140.0) Gecko/20100101 Firefox/140.0"
TODAY = date(2026, 3, 31)


def asked(path="/", agent=BROWSER, method="GET", **headers):
    given = [(b"user-agent", agent)] if agent is not None else []
    given += [(name.replace("_", "-").encode(), value) for name, value in headers.items()]
    return {"type": "http", "method": method, "path": path, "headers": given, "client": ("192.0.2.1", 1)}


def test_a_page_that_a_person_opens_counts():
    assert is_page(asked())
    assert is_page(asked("/robots/mercury/", sec_fetch_dest=b"document"))


@pytest.mark.parametrize(
    "agent",
    [
        b"Mozilla/5.0 (compatible; Googlebot/2.1; +http://www.google.com/bot.html)", b"curl/8.5.0", b"kube-probe/1.30",
        b"Mozilla/5.0 (compatible; bingbot/2.0)", b"python-requests/2.32", b"Go-http-client/2.0", b"Wget/1.21", b"",
        b"facebookexternalhit/1.1", b"Slackbot-LinkExpanding 1.0", b"UptimeRobot/2.0", None, b"Mozilla/5.0",
        b"Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 HeadlessChrome/140.0.0.0 Safari/537.36",
    ],
)  # fmt: skip
def test_programs_that_say_so_do_not_count(agent):
    assert not is_page(asked(agent=agent))


def test_parts_of_pages_and_pages_in_advance_do_not_count():
    assert not is_page(asked(sec_fetch_dest=b"empty"))
    assert not is_page(asked(sec_fetch_dest=b"iframe"))
    assert not is_page(asked(sec_purpose=b"prefetch;prerender"))
    assert not is_page(asked(method="HEAD"))
    assert not is_page(asked("/admin/robots/"))
    assert not is_page(asked() | {"type": "websocket"})


def test_a_page_belongs_to_the_robot_of_its_address():
    found = [
        robot_of(path) for path in ("/robots/mercury/jobs/", "/classic/irat/x/", "/log/", "/robots//", "/robots/a b/")
    ]
    assert found == ["mercury", "irat", ALL, ALL, ALL]


def test_a_million_addresses_take_bounded_memory():
    hits = Hits(most=100)
    for n in range(1000):
        hits.note(TODAY, "mercury", f"10.{n >> 8}.{n & 255}.1")
    counts = hits.take()[TODAY]
    assert counts.remembered() == 100
    assert not counts.whole, "the day says that there were more"
    assert dict(counts.hits) == {ALL: 1000, "mercury": 1000}
    assert hits.empty()


def test_addresses_of_one_ipv6_network_are_one():
    hits = Hits()
    for n in range(50):
        hits.note(TODAY, ALL, f"2001:db8:1:2::{n:x}")
    assert hits.take()[TODAY].addresses[ALL] == {"2001:db8:1:2::/64"}


def test_what_is_put_back_is_counted_once_more_and_no_more():
    hits = Hits()
    hits.note(TODAY, ALL, "192.0.2.1")
    left = hits.take()
    hits.note(TODAY, ALL, "192.0.2.2")
    hits.put_back(left)
    counts = hits.take()[TODAY]
    assert (counts.hits[ALL], counts.addresses[ALL], counts.whole) == (2, {"192.0.2.1", "192.0.2.2"}, True)


def day(n, **values):
    return Day(TODAY + timedelta(days=n), values)


def test_milestones_are_the_first_and_round_numbers():
    found = milestones(
        [day(0, turns=0), day(1, turns=3), day(2, turns=None), day(3, turns=96), day(4, turns=1), day(5, turns=9900)]
    )
    said = [(one.day - TODAY, one.text) for one in found]
    assert said == [(timedelta(1), "First turn"), (timedelta(4), "100 turns"), (timedelta(5), "10,000 turns")]


def test_bytes_and_seconds_are_counted_in_their_units():
    found = milestones([day(0, sent_bytes=99e9, online_s=100 * 3600.0), day(1, sent_bytes=1e9)])
    assert [one.text for one in found] == ["100 hours online", "100 GB sent"]


numbers = st.one_of(st.none(), st.integers(0, 10**9))


@given(st.lists(numbers, min_size=1, max_size=60))
def test_a_milestone_is_never_early_and_each_comes_once(values):
    days = [day(n, hits=value) for n, value in enumerate(values)]
    found = milestones(days)
    assert len({one.number for one in found}) == len(found)
    assert [one.day for one in found] == sorted(one.day for one in found)
    for one in found:
        before = sum(other.values["hits"] or 0 for other in days if other.day < one.day)
        until = sum(other.values["hits"] or 0 for other in days if other.day <= one.day)
        assert before < one.number <= until


@given(st.lists(numbers, min_size=1, max_size=20))
def test_a_total_is_whole_only_if_each_day_is_known(values):
    total = next(one for one in totals([day(n, turns=v) for n, v in enumerate(values)]) if one.figure.name == "turns")
    assert total.whole is (None not in values)
    assert total.value == sum(value or 0 for value in values)


@given(st.lists(st.one_of(st.none(), st.floats(0, 1e15)), min_size=1, max_size=365), st.data())
def test_bars_stay_in_the_plot_and_an_unknown_day_is_no_zero(values, data):
    dates = [TODAY + timedelta(days=n) for n in range(len(values))]
    marked = data.draw(st.sets(st.sampled_from(dates)))
    plot = plots.days([(one, value, "x") for one, value in zip(dates, values, strict=True)], marked)
    assert len(plot.bars) == len(values)
    for bar, value in zip(plot.bars, values, strict=True):
        assert plots.LEFT <= bar.x <= bar.x + bar.width <= plots.RIGHT + 0.01
        assert (bar.css == "unknown") is (value is None)
        if value is not None:
            assert plots.TOP - 0.01 <= bar.y <= plots.BOTTOM
            assert bar.y + bar.height == pytest.approx(plots.BOTTOM)
    assert [flag.text for flag in plot.flags] == [str(n + 1) for n in range(len(marked))]
    assert len(plot.across) <= plots.DATES


def test_a_number_says_what_is_not_known():
    assert [number(v) for v in (None, 0, 12345.0, 1.5)] == ["not known", "0", "12,345", "1.50"]
    assert number(7, whole=False) == "at least 7"


def test_each_figure_has_a_title_and_says_what_it_means():
    assert all(figure.title and figure.means.endswith(".") for figure in FIGURES)
