"""Whether the time of an answer tells if an address has an account: sign-in, sign-up and password reset, each with a known and an unknown address.

Known and unknown are asked for in turns in one run (OWASP ASVS 5.0, 6.3.8), with passwords
hashed as in production and mails sent beside the answer.
"""

import os
import time
from collections.abc import Callable
from typing import Any

from benchmarks.stage import cast, database, median, set_up, tell

RUNS = int(os.environ.get("RUNS", "500"))
WARM = 10
GOAL = 0.05


def main() -> None:
    """Ask each form `RUNS` times for known and for unknown addresses."""
    set_up()
    with database():
        found = _measure()
    worst = max(abs(one["known_ms"] / one["unknown_ms"] - 1) for one in found.values())
    tell(
        "known_address", worst, f"largest relative difference of medians, {RUNS} each", "<= 0.05", worst <= GOAL, found
    )


def _measure() -> dict[str, dict[str, float]]:
    from django.test import Client, override_settings
    from django.test.utils import setup_test_environment, teardown_test_environment

    from tests.conftest import RedisServer

    redis = RedisServer()
    redis.start()
    cast()
    from allauth.account.models import EmailAddress
    from django.contrib.auth import get_user_model
    from django.contrib.auth.hashers import make_password

    setup_test_environment(debug=False)
    words = {"password1": "correct horse 42"}

    def post(path: str, number: int, **data: str) -> Any:
        # an address of its own each time: the limits are not what is measured
        client = Client(REMOTE_ADDR=f"10.{number >> 16 & 255}.{number >> 8 & 255}.{number & 255}")
        return client.post(path, data)

    asked: dict[str, Callable[[int, bool], Any]] = {
        "sign-in": lambda n, known: post(
            "/accounts/login/", n, login=f"known{n}@example.org" if known else f"no{n}@example.org", password="wrong horse 13"
        ),
        "sign-up": lambda n, known: post(
            "/accounts/signup/", n, email=f"known{n}@example.org" if known else f"new{n}@example.org", username=f"name{n}", **words
        ),
        "password reset": lambda n, known: post(
            "/accounts/password/reset/", n, email=f"known{n}@example.org" if known else f"no{n}@example.org"
        ),
    }  # fmt: skip
    try:
        with override_settings(PASSWORD_HASHERS=_production(), MAIL_IN_BACKGROUND=True, ALLOWED_HOSTS=["*"]):
            hashed, kind = make_password("correct horse 42"), get_user_model()
            for n in range(2 * (RUNS + WARM)):  # one each: a form counts what is asked of one address, too
                user = kind.objects.create(username=f"known{n}", email=f"known{n}@example.org", password=hashed)
                EmailAddress.objects.create(user=user, email=user.email, verified=True, primary=True)
            return {name: _pair(ask) for name, ask in asked.items()}
    finally:
        teardown_test_environment()
        redis.stop()


def _production() -> list[str]:
    from django.conf import global_settings

    return list(global_settings.PASSWORD_HASHERS)


def _pair(ask: Callable[[int, bool], Any]) -> dict[str, float]:
    times: dict[bool, list[float]] = {True: [], False: []}
    for n in range(RUNS + WARM):
        for known in (n % 2 == 0, n % 2 == 1):
            begun = time.perf_counter()
            answer = ask(2 * n + known, known)
            took = time.perf_counter() - begun
            assert answer.status_code in (200, 302), answer.status_code
            if n >= WARM:
                times[known].append(took * 1000)
    return {"known_ms": round(median(times[True]), 2), "unknown_ms": round(median(times[False]), 2)}


if __name__ == "__main__":
    main()
