"""Web Push from the attacker's side: other people's browsers, foreign addresses, endless texts, private networks."""

import socket
import ssl

import pytest
from cryptography.hazmat.primitives.asymmetric import ec
from django.test import Client
from hypothesis import given
from hypothesis import strategies as st

from accounts import push
from accounts.models import PushSubscription
from accounts.push import PushRefused
from accounts.sessions import end_sessions
from portal.web import outgoing
from portal.web.push import messages
from portal.web.push.views import browser_of
from robots.kit.clock import SYSTEM
from tests.services.push_service import Browser, point, write_b64

pytestmark = [pytest.mark.service, pytest.mark.django_db]
HERE = "https://push.example.org/send/"
JSON = {"accept": "application/json"}
SECRET = "correct horse 42"


@pytest.fixture
def of(people):
    """A browser of each person, signed in."""
    made = {}

    def client(name):
        if name not in made:
            made[name] = Client()
            made[name].login(username=name, password=SECRET)
        return made[name]

    return client


def send(client, do, **fields):
    return client.post("/me/push/", {"do": do, **fields}, headers=JSON)


def owners():
    return dict(PushSubscription.objects.values_list("endpoint", "user__username"))


def test_a_browser_is_stored_for_who_is_signed_in_whoever_a_form_names(of, people):
    one = Browser(HERE + "a")
    assert send(of("ada"), "tell", user=people["bob"].pk, user_id=people["bob"].pk, **one.fields).status_code == 200
    assert owners() == {one.endpoint: "ada"}
    assert send(of("ada"), "tell", **one.fields).json() == {"ok": True, "text": ""}, "twice is once"
    assert PushSubscription.objects.count() == 1


def test_without_a_session_or_with_a_foreign_form_nothing_is_stored(people):
    one = Browser(HERE + "a")
    assert send(Client(), "tell", **one.fields).status_code == 302
    strict = Client(enforce_csrf_checks=True)
    strict.login(username="ada", password=SECRET)
    assert send(strict, "tell", **one.fields).status_code == 403
    assert owners() == {}
    token = strict.get("/me/push/", headers=JSON).json()["token"]
    assert send(strict, "tell", csrfmiddlewaretoken=token, **one.fields).status_code == 200
    assert owners() == {one.endpoint: "ada"}


def test_who_has_only_read_an_endpoint_takes_it_from_nobody(of):
    one = Browser(HERE + "a")
    send(of("ada"), "tell", **one.fields)
    refused = send(of("bob"), "tell", **Browser(one.endpoint).fields)
    assert (refused.status_code, refused.json()["ok"]) == (400, False)
    assert owners() == {one.endpoint: "ada"}
    assert send(of("bob"), "tell", **one.fields).status_code == 200, "the same browser, of another person now"
    assert owners() == {one.endpoint: "bob"}
    assert send(of("ada"), "stop").status_code == 200
    assert owners() == {one.endpoint: "bob"}, "it is not hers any more"


def test_nobody_removes_another_persons_browser(of):
    one, two = Browser(HERE + "a"), Browser(HERE + "b")
    send(of("ada"), "tell", **one.fields)
    send(of("bob"), "tell", **two.fields)
    number = PushSubscription.objects.get(endpoint=one.endpoint).pk
    for wanted in (number, -number, 0, "x", "9" * 400, ""):
        send(of("bob"), "remove", number=wanted)
    assert owners() == {one.endpoint: "ada", two.endpoint: "bob"}
    page = of("bob").get("/me/").content.decode()
    assert f'value="{number}"' not in page
    assert one.endpoint not in of("ada").get("/me/").content.decode(), "an address is shown to nobody"
    for _ in range(2):
        assert of("ada").post("/me/push/", {"do": "remove", "number": number}).status_code == 302
    assert owners() == {two.endpoint: "bob"}


def test_a_worker_renews_only_the_browser_that_is_told(of):
    one, two = Browser(HERE + "a"), Browser(HERE + "b")
    assert send(of("ada"), "renew", **two.fields).status_code == 400
    send(of("ada"), "tell", **one.fields)
    assert send(of("ada"), "renew", **two.fields).status_code == 200
    assert owners() == {two.endpoint: "ada"}
    send(of("ada"), "stop")
    assert send(of("ada"), "renew", **one.fields).status_code == 400
    assert owners() == {}


def test_a_person_has_ten_browsers_and_the_oldest_goes(of, people):
    now = SYSTEM.now()
    keys = messages.checked_keys(*list(Browser("").fields.values())[1:])
    for number in range(push.MOST + 3):
        push.subscribe(people["ada"], f"{HERE}{number}", keys, "", now)
    push.subscribe(people["bob"], f"{HERE}bob", keys, "", now)
    kept = {f"{HERE}{number}" for number in range(3, push.MOST + 3)}
    assert {endpoint for endpoint, name in owners().items() if name == "ada"} == kept


def test_changes_of_a_person_are_limited(of, one_count):
    answers = [send(of("ada"), "stop").status_code for _ in range(31)]
    assert answers == [200] * 30 + [429]


@pytest.mark.parametrize("end", ["sign_out", "switch_off", "delete", "new_password"])
def test_who_is_signed_out_is_told_no_more(of, people, end):
    mine, elsewhere = Browser(HERE + "a"), Browser(HERE + "b")
    send(of("ada"), "tell", **mine.fields)
    phone = Client()
    phone.login(username="ada", password=SECRET)
    send(phone, "tell", **elsewhere.fields)
    send(of("bob"), "tell", **Browser(HERE + "bob").fields)
    ada = people["ada"]
    if end == "sign_out":
        of("ada").post("/accounts/logout/")
    elif end == "switch_off":
        ada.is_active = False
        ada.save()
    elif end == "delete":
        ada.delete()
    else:
        ada.set_password("another horse 43")
        ada.save()
    left = {elsewhere.endpoint} if end == "sign_out" else set()
    assert owners().keys() == left | {HERE + "bob"}


def test_sessions_that_staff_end_end_their_browsers(of, people):
    send(of("ada"), "tell", **Browser(HERE + "a").fields)
    end_sessions(people["ada"])
    assert owners() == {}


GOOD = Browser(HERE + "a", ec.derive_private_key(7, ec.SECP256R1())).fields


@pytest.mark.parametrize(
    "endpoint",
    ["", "x", "http://push.example.org/a", "https://", "https:///a", "file:///etc/passwd", "https://user:pw@push.example.org/a",
     "https://push.example.org:99999/a", "https://push.example.org:8443/a", "https://push.example.org/#a", "https://localhost/a",
     "https://redis/a", "https://127.0.0.1/a", "https://10.0.0.1/a", "https://[::1]/a", "https://[::ffff:10.0.0.1]/a",
     "https://[64:ff9b::a00:1]/a", "https://[fd00::1]/a", "https://169.254.169.254/a", "https://2130706433/a", "https://0x7f.1/a",
     "https://push.example.org/a b", "https://push.example.org/a\r\nHost: x", "https://pu\u017fh.example.org/", "https://push_.example..org/",
     HERE + "a" * 1000],
)  # fmt: skip
def test_an_address_that_is_no_push_service_is_refused_in_a_sentence(of, endpoint):
    refused = send(of("ada"), "tell", **{**GOOD, "endpoint": endpoint})
    assert refused.status_code == 400
    assert refused.json()["text"].endswith(".")
    assert owners() == {}


@pytest.mark.parametrize(
    ("p256dh", "auth"),
    [("", GOOD["auth"]), (GOOD["p256dh"], ""), (write_b64(b"\4" + bytes(64)), GOOD["auth"]), (GOOD["p256dh"][:-4], GOOD["auth"]),
     (GOOD["p256dh"], write_b64(bytes(17))), (GOOD["p256dh"] * 9999, GOOD["auth"]), ("\u00e4" * 87, GOOD["auth"]), (GOOD["p256dh"], "!" * 22)],
)  # fmt: skip
def test_keys_that_are_none_are_refused_in_a_sentence(of, p256dh, auth):
    refused = send(of("ada"), "tell", endpoint=HERE, p256dh=p256dh, auth=auth)
    assert (refused.status_code, refused.json()["ok"]) == (400, False)
    assert owners() == {}


@given(st.text(max_size=200), st.text(max_size=200), st.text(max_size=1200))
def test_whatever_is_sent_is_stored_in_bounds_or_refused(p256dh, auth, endpoint):
    for check, arguments in ((messages.checked_keys, (p256dh, auth)), (messages.checked_endpoint, (endpoint,))):
        try:
            found = check(*arguments)
        except PushRefused:
            continue
        assert len(found) <= 1000


@given(st.binary(min_size=16, max_size=16))
def test_keys_are_stored_in_one_form(secret):
    key = Browser("").key
    plain = write_b64(point(key)), write_b64(secret)
    assert messages.checked_keys(*plain) == plain
    assert messages.checked_keys(*(f"{one}{'=' * (-len(one) % 4)}" for one in plain)) == plain


@given(st.text(max_size=400))
def test_a_browsers_name_is_made_of_known_words(agent):
    assert len(browser_of(agent)) <= push.LONGEST_BROWSER


@pytest.mark.parametrize(
    ("agent", "name"),
    [
        ("Mozilla/5.0 (X11; Linux x86_64; rv:140.0) Gecko/20100101 Firefox/140.0", "Firefox, Linux"),
        ("Mozilla/5.0 (Linux; Android 14) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/140.0 Mobile Safari/537.36", "Chrome, Android"),
        ("Mozilla/5.0 (Windows NT 10.0) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/140.0 Safari/537.36 Edg/140.0", "Edge, Windows"),
        ("Mozilla/5.0 (iPhone; CPU iPhone OS 18_0 like Mac OS X) AppleWebKit/605 Version/18.0 Mobile Safari/604.1", "Safari, iPhone"),
        ("<script>", ""),
    ],
)  # fmt: skip
def test_a_browser_is_listed_by_its_name(agent, name):
    assert browser_of(agent) == name


@pytest.mark.parametrize(
    "address",
    ["127.0.0.1", "10.0.0.5", "192.168.1.1", "172.16.0.1", "100.64.0.1", "169.254.169.254", "0.0.0.0", "224.0.0.1", "255.255.255.255",
     "::1", "::", "fd00::1", "fe80::1%eth0", "fec0::1", "ff02::1", "::ffff:10.0.0.1", "::10.0.0.1", "64:ff9b::10.0.0.1", "2002:a00:1::",
     "2001:db8::1"],
)  # fmt: skip
def test_no_address_but_one_of_the_internet_is_public(address):
    assert not outgoing.is_public(address)


@pytest.mark.parametrize(
    "address", ["93.184.216.34", "2606:4700::1111", "::ffff:93.184.216.34", "64:ff9b::93.184.216.34"]
)
def test_addresses_of_the_internet_are(address):
    assert outgoing.is_public(address)


def test_a_name_that_leads_into_the_private_network_is_not_connected_to(monkeypatch):
    """One of its addresses is enough; and what was judged is what is connected to."""
    opened = []

    def connect(place, **_):
        opened.append(place[0])
        raise ConnectionRefusedError

    monkeypatch.setattr(socket, "create_connection", connect)
    for found in (["127.0.0.1"], ["93.184.216.34", "10.0.0.1"]):
        monkeypatch.setattr(
            socket, "getaddrinfo", lambda *_, found=found, **__: [(0, 0, 0, "", (one, 443)) for one in found]
        )
        with pytest.raises(outgoing.NotPublic):
            outgoing.post(HERE, b"", {}, messages.LIMITS, private=False)
    assert opened == []
    rebinding = iter([["93.184.216.34"], ["127.0.0.1"]])
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [(0, 0, 0, "", (one, 443)) for one in next(rebinding)])
    monkeypatch.setattr(outgoing, "tls", ssl.create_default_context)
    with pytest.raises(outgoing.NotReached):
        outgoing.post(HERE, b"", {}, messages.LIMITS, private=False)
    assert opened == ["93.184.216.34"]


def test_the_worker_is_one_script_at_the_root_that_may_not_be_kept(client):
    answer = client.get("/push-worker.js")
    assert answer["Content-Type"].startswith("text/javascript")
    assert answer["Cache-Control"] == "no-cache"
    assert "worker-src 'self'" in answer["Content-Security-Policy"]
    script = answer.content.decode()
    assert "import" not in script, "a service worker is loaded as one file"
    assert "caches" not in script
    assert "fetch`" not in script, "it answers no request of a page"


def test_a_page_has_the_public_key_and_never_the_private_one(of, settings):
    page = of("ada").get("/me/").content.decode()
    assert messages.public_key() in page
    assert settings.PUSH["KEY"] not in page
    assert "data-push" not in Client().get("/").content.decode()
