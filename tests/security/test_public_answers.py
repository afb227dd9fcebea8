"""Headers, cookies and addresses of a portal on the open web."""

import pytest


@pytest.mark.asvs("3.4.1", "3.4.3", "3.4.4", "3.4.5", "3.4.6", "3.4.2")
def test_every_answer_carries_the_headers_that_bind_a_browser(public):
    for address, answer in public["answers"].items():
        headers = {k.lower(): v for k, v in answer["headers"].items()}
        assert headers["strict-transport-security"] == "max-age=31536000; includeSubDomains; preload", address
        assert headers["x-content-type-options"] == "nosniff", address
        assert headers["referrer-policy"] == "same-origin", address
        assert "access-control-allow-origin" not in headers, address
        devices = headers["permissions-policy"]
        assert "hid=(self)" in devices, address
        assert "camera=()" in devices, address
        policy = headers["content-security-policy"]
        assert "unsafe" not in policy, address
        for part in ("default-src 'self'", "object-src 'none'", "base-uri 'none'", "frame-ancestors 'none'"):
            assert part in policy, address


@pytest.mark.asvs("3.3.1", "3.3.2", "3.3.3", "3.3.4")
def test_cookies_are_bound_to_this_host_and_to_tls(public):
    cookies = public["session"] | public["answers"]["GET /accounts/login/"]["cookies"]
    assert {"__Host-sessionid", "__Host-csrftoken"} <= set(cookies)
    for name, cookie in cookies.items():
        assert cookie["secure"], name
        assert cookie["samesite"] in ("Lax", "Strict"), name
        assert cookie["path"] == "/", name
        assert not cookie["domain"], name
    assert cookies["__Host-sessionid"]["httponly"]


@pytest.mark.asvs("12.2.1")
def test_plain_http_leads_to_tls(public):
    status, where = public["plain"]
    assert status == 301
    assert where == "https://robots.example.org/"


@pytest.mark.asvs("14.3.2", "14.2.2")
def test_private_pages_are_kept_nowhere(public):
    status, headers = public["me"]
    assert status == 200
    assert "no-store" in headers["Cache-Control"]
    assert "private" in headers["Cache-Control"]


@pytest.mark.asvs("13.4.1", "13.4.2", "13.4.3", "13.4.4", "15.2.3")
def test_nothing_is_served_that_is_no_page(public):
    answers = public["answers"]
    assert public["settings"]["DEBUG"] == "False"
    for address in ("GET /.git/config", "GET /static/", "GET /media/frames/", "GET /nowhere/"):
        assert answers[address]["status"] == 404, address
    assert answers["TRACE /"]["status"] == 405


@pytest.mark.asvs("4.1.1", "3.2.1")
def test_every_answer_says_what_it_is(public):
    for address, answer in public["answers"].items():
        if answer["status"] < 300:
            kind = answer["headers"]["Content-Type"]
            assert "charset=utf-8" in kind or kind in ("image/svg+xml", "application/json"), (address, kind)


@pytest.mark.asvs("7.3.2", "6.5.5")
def test_sessions_and_mailed_links_run_out(public):
    assert int(public["settings"]["SESSION_COOKIE_AGE"]) <= 14 * 24 * 3600
    assert int(public["settings"]["PASSWORD_RESET_TIMEOUT"]) <= 24 * 3600


@pytest.mark.asvs("11.4.2", "11.2.1", "11.4.1", "11.2.3", "11.4.3")
def test_passwords_are_stored_by_a_slow_function(public):
    first = public["settings"]["PASSWORD_HASHERS"].strip("[]").split(",")[0]
    assert "PBKDF2PasswordHasher" in first or "Argon2" in first or "Scrypt" in first
