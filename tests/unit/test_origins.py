"""Who may open a socket: scheme, host and port of the origin are those of the request, or of a setting."""

import pytest

from portal.edge.origins import may_open


def scope(origin, host="robots.example.org", scheme="wss"):
    origins = origin if isinstance(origin, list) else [origin]
    return {"type": "websocket", "scheme": scheme,
            "headers": [(b"host", host.encode()), *((b"origin", o.encode("latin-1")) for o in origins)]}  # fmt: skip


@pytest.fixture(autouse=True)
def site(settings):
    settings.ALLOWED_HOSTS = ["robots.example.org", "localhost", "[::1]"]
    settings.CSRF_TRUSTED_ORIGINS = []


@pytest.mark.parametrize(
    ("origin", "host", "scheme"),
    [
        ("https://robots.example.org", "robots.example.org", "wss"), ("https://robots.example.org", "robots.example.org:443", "wss"),
        ("http://localhost:8000", "localhost:8000", "ws"), ("http://[::1]:8000", "[::1]:8000", "ws"), ("http://localhost", "LOCALHOST:80", "ws"),
    ],
)  # fmt: skip
def test_the_sites_own_pages_may(origin, host, scheme):
    assert may_open(scope(origin, host, scheme))


STRANGE = [
    [], "", "null", "https://evil.example", "http://robots.example.org", "https://robots.example.org:8443",
    "https://robots.example.org.evil.example", "https://x.robots.example.org", "https://robots.example.org@evil.example",
    "https://evil.example#robots.example.org", "file://", "https://robots.example.org/", "wss://robots.example.org",
    ["https://robots.example.org", "https://evil.example"], "https://robots.example.org https://evil.example", "https://róbots.example.org",
]  # fmt: skip


@pytest.mark.asvs("4.4.2")
@pytest.mark.parametrize("origin", STRANGE)
def test_everybody_elses_may_not(origin):
    assert not may_open(scope(origin))


def test_a_host_that_is_not_ours_may_not_though_the_origin_says_the_same():
    assert not may_open(scope("https://evil.example", host="evil.example"))
    assert not may_open({"scheme": "wss", "headers": [(b"origin", b"https://robots.example.org")]})


def test_a_setting_may_name_other_origins(settings):
    settings.CSRF_TRUSTED_ORIGINS = ["https://museum.example", "https://*.example.net:444", "http://[::1]:9"]
    assert may_open(scope("https://museum.example"))
    assert may_open(scope("https://a.example.net:444"))
    assert may_open(scope("http://[::1]:9"))
    for origin in ("http://museum.example", "https://museum.example:444", "https://a.example.net", "https://xexample.net:444", "http://[::1]"):  # fmt: skip
        assert not may_open(scope(origin))
