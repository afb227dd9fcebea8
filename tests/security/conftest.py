"""The portal with the settings of the open web, asked in a process of its own."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests import migrated

ROOT = Path(__file__).resolve().parent.parent.parent

ASK = """
import json, sys
import django
django.setup()
from django.conf import settings
from django.core.management import call_command
call_command("migrate", verbosity=0)
from django.contrib.auth import get_user_model
from django.test import Client
get_user_model().objects.create_superuser("root", "root@example.org", "a long enough phrase 7")
client = Client(headers={"host": "robots.example.org"}, enforce_csrf_checks=True)
found = {"settings": {name: repr(getattr(settings, name)) for name in json.loads(sys.argv[1])}, "answers": {}}
for address in json.loads(sys.argv[2]):
    method, _, path = address.partition(" ")
    answer = client.generic(method, path, secure=True)
    found["answers"][address] = {
        "status": answer.status_code, "headers": dict(answer.items()),
        "cookies": {k: {a: v[a] for a in ("secure", "httponly", "samesite", "path", "domain")} for k, v in answer.cookies.items()},
    }
plain = client.get("/", secure=False)
found["plain"] = [plain.status_code, plain.get("Location", "")]
from allauth.account.models import EmailAddress
EmailAddress.objects.create(user=get_user_model().objects.get(), email="root@example.org", verified=True, primary=True)
client.get("/accounts/login/", secure=True)
token = client.cookies[settings.CSRF_COOKIE_NAME].value
form = {"login": "root", "password": "a long enough phrase 7", "csrfmiddlewaretoken": token}
signed_in = client.post("/accounts/login/", form, secure=True, headers={"referer": "https://robots.example.org/accounts/login/"})
assert signed_in.status_code == 302, signed_in.content
answer = client.get("/me/", secure=True)
found["me"] = [answer.status_code, dict(answer.items())]
found["session"] = {k: {a: v[a] for a in ("secure", "httponly", "samesite", "path", "domain")} for k, v in client.cookies.items()}
print(json.dumps(found))
"""
NAMES = ["DEBUG", "SESSION_COOKIE_AGE", "PASSWORD_HASHERS", "AUTH_PASSWORD_VALIDATORS", "PASSWORD_RESET_TIMEOUT"]
ADDRESSES = ["GET /", "GET /log/", "GET /accounts/login/", "GET /livez", "GET /nowhere/", "GET /static/portal/icon.svg",
             "GET /.git/config", "GET /static/", "GET /media/frames/", "TRACE /", "GET /admin/login/"]  # fmt: skip


@pytest.fixture(scope="session")
def public(tmp_path_factory):
    """What a public portal answers: settings, headers, cookies."""
    folder = tmp_path_factory.mktemp("public")
    migrated.begin(folder / "db.sqlite3")
    env = os.environ | {
        "FARHAND_PUBLIC": "1", "FARHAND_VAR": str(folder), "DATABASE_URL": f"sqlite:///{folder / 'db.sqlite3'}",
        "ALLOWED_HOSTS": "robots.example.org", "DJANGO_SETTINGS_MODULE": "portal.settings", "LOG_LEVEL": "ERROR",
        "EMAIL_URL": "smtp://mail.example.org:587", "PYTHONPATH": str(ROOT),
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", ASK, json.dumps(NAMES), json.dumps(ADDRESSES)],
        env=env, cwd=ROOT, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout.splitlines()[-1])
