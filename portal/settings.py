"""Settings, all from the environment; without any, the demo on this machine.

`docs/reference/settings.md` lists every variable.
"""

import secrets
import sys
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import environ
from csp.constants import NONE, SELF
from django.core.exceptions import ImproperlyConfigured

from portal.addresses import check_database, read_url, redis_tls, site_address
from portal.edge.addresses import proxy_networks
from portal.folders import FRONTEND_DIST, ROOT, TEMPLATES_DIR, default_var, keep_private, kept_secret, new_push_key
from portal.languages import *  # noqa: F403 - settings
from portal.run import roles

env = environ.Env()
BASE_DIR = ROOT
VAR = Path(env.str("FARHAND_VAR", str(default_var())))
keep_private(VAR)
ROLE = env.str("FARHAND_ROLE", "web")  # web, owner, housekeeping, recorder, broadcast, edge; see portal/run/roles.py

DEBUG = env.bool("DEBUG", False)
PUBLIC = env.bool("FARHAND_PUBLIC", False)  # behind TLS, on the open web

SECRET_KEY = env.str("SECRET_KEY", "") or kept_secret(VAR / "secret_key", lambda: secrets.token_urlsafe(64))

ALLOWED_HOSTS = env.list("ALLOWED_HOSTS", default=["localhost", "127.0.0.1", "[::1]"])
if "*" in ALLOWED_HOSTS:
    raise ImproperlyConfigured("ALLOWED_HOSTS must name the hosts: '*' would switch the origin check of sockets off.")
CSRF_TRUSTED_ORIGINS = env.list("CSRF_TRUSTED_ORIGINS", default=[])

PORT = env.int("FARHAND_PORT", 8000)
SITE_ADDRESS = site_address(env.str("FARHAND_URL", ""), CSRF_TRUSTED_ORIGINS, ALLOWED_HOSTS, PUBLIC, PORT)

INSTALLED_APPS = [
    "portal.web.staff.apps.StaffConfig",
    *(f"django.contrib.{one}" for one in ("auth", "contenttypes", "sessions", "messages", "staticfiles", "humanize")),
    "django.forms",
    "allauth",
    "allauth.account",
    "csp",
    "django_vite",
    "channels",
    "robots",
    "accounts",
    "queueing",
    "operatorlog",
    "portal",
    *(f"portal.web.{one}" for one in ("classic", "daily", "alerts", "feeds")),
]
MIDDLEWARE = [
    "portal.web.pages.middleware.KnownHost",
    "django.middleware.security.SecurityMiddleware",
    "csp.middleware.CSPMiddleware",
    "portal.web.pages.middleware.Devices",
    "portal.web.pages.middleware.KnownMethods",
    "portal.web.pages.middleware.StaticFiles",
    "django.contrib.sessions.middleware.SessionMiddleware",
    "portal.web.translation.middleware.ReaderLanguage",
    "portal.web.translation.middleware.ReaderZone",
    "django.middleware.common.CommonMiddleware",
    "django.middleware.csrf.CsrfViewMiddleware",
    "django.contrib.auth.middleware.AuthenticationMiddleware",
    "django.contrib.messages.middleware.MessageMiddleware",
    "django.middleware.clickjacking.XFrameOptionsMiddleware",
    "portal.web.pages.practice.Guests",
    "allauth.account.middleware.AccountMiddleware",
    "portal.logs.security.RefusalLog",
    "portal.web.pages.middleware.PlainText",
    "portal.web.pages.middleware.PrivatePages",
]
ROOT_URLCONF = "portal.urls"
ASGI_APPLICATION = "portal.asgi.application"
FORM_RENDERER = "django.forms.renderers.TemplatesSetting"  # ours may replace the templates of a field
TEMPLATES = [
    {
        "BACKEND": "django.template.backends.django.DjangoTemplates",
        "DIRS": [TEMPLATES_DIR],
        "OPTIONS": {
            "loaders": [
                (
                    "django.template.loaders.cached.Loader",
                    [
                        "django.template.loaders.filesystem.Loader",
                        "django.template.loaders.app_directories.Loader",
                        "portal.web.consoles.files.Loader",
                    ],
                )
            ],
            "context_processors": [
                "django.template.context_processors.request",
                "django.contrib.auth.context_processors.auth",
                "django.contrib.messages.context_processors.messages",
                "portal.web.context.site",
            ],
        },
    }
]


def _database() -> dict[str, Any]:
    config: dict[str, Any] = {"CONN_MAX_AGE": 60} | read_url(
        "DATABASE_URL", lambda: env.db("DATABASE_URL", default=f"sqlite:///{VAR / 'farhand.sqlite3'}")
    )
    config["HOST"] = unquote(config.get("HOST") or "")  # %2Fvar%2Frun is a socket, as libpq writes it
    if config["ENGINE"].endswith("sqlite3"):
        config["OPTIONS"] = {"transaction_mode": "IMMEDIATE"}
        config["TEST"] = {"NAME": VAR / "test.sqlite3"}  # processes of the tests need a file, not memory
    else:
        check_database(config.get("OPTIONS", {}))
        # the same few statements repeat: planned once per connection, not at each call
        config["ENGINE"] = "portal.postgres"
        config["OPTIONS"] = {
            "connect_timeout": 3, "server_side_binding": True, "prepare_threshold": 5,
        } | config.get("OPTIONS", {})  # fmt: skip
    config["OPTIONS"].update(roles.database_options(config["ENGINE"], ROLE))
    return config


DATABASES = {"default": _database()}
DEFAULT_AUTO_FIELD = "django.db.models.BigAutoField"

REDIS_URL = env.str("REDIS_URL", f"unix://{VAR / 'redis.sock'}")
read_url("REDIS_URL", lambda: urlsplit(REDIS_URL).port)
REDIS_TIMEOUT_S = roles.REDIS_TIMEOUT_S
CELERY_BROKER_URL = REDIS_URL.replace("unix://", "redis+socket://") if REDIS_URL.startswith("unix://") else REDIS_URL
if _redis_tls := redis_tls(REDIS_URL):  # by the address alone Celery would check no certificate
    CELERY_BROKER_URL, CELERY_BROKER_USE_SSL = REDIS_URL.partition("?")[0], _redis_tls
CELERY_BROKER_TRANSPORT_OPTIONS = roles.broker_options(ROLE)
CELERY_BROKER_CONNECTION_RETRY_ON_STARTUP = True
CELERY_IMPORTS = ("workers.process.tasks", "workers.process.bootstep")  # in workers only
CELERY_DB_REUSE_MAX = sys.maxsize  # Celery closes no connection; `portal/celery.py` closes old and broken ones
CELERY_TASK_IGNORE_RESULT = True
CELERY_TASK_PUBLISH_RETRY = False
CELERY_WORKER_PREFETCH_MULTIPLIER = 1
CELERY_WORKER_SEND_TASK_EVENTS = False
CELERY_WORKER_ENABLE_REMOTE_CONTROL = False
CELERY_WORKER_CANCEL_LONG_RUNNING_TASKS_ON_CONNECTION_LOSS = False
CELERY_WORKER_HIJACK_ROOT_LOGGER = False
CELERY_TASK_DEFAULT_QUEUE = "housekeeping"
CELERY_TIMEZONE = "UTC"
CELERY_BEAT_SCHEDULE = {
    "queue-tick": {"task": "queueing.tick", "schedule": 1.0, "options": {"expires": 5, "queue": "ticks"}},
    "probes": {"task": "robots.probe", "schedule": 60.0, "options": {"expires": 30, "queue": "probes"}},
    "online": {"task": "robots.online", "schedule": 60.0, "options": {"expires": 30}},
    "clean": {"task": "robots.clean", "schedule": 3600.0},
    "clean-jobs": {"task": "queueing.clean", "schedule": 3600.0},
    "alerts": {"task": "alerts.tell", "schedule": 30.0, "options": {"expires": 25, "queue": "alerts"}},
    "push": {"task": "push.tell", "schedule": 1.0, "options": {"expires": 5, "queue": "push"}},
    "turn-mails": {"task": "push.mail", "schedule": 2.0, "options": {"expires": 5, "queue": "mails"}},
    "daily": {"task": "daily.figures", "schedule": 900.0},
    "downtimes": {"task": "feeds.downtimes", "schedule": 60.0, "options": {"expires": 30}},
}

AUTH_USER_MODEL = "accounts.User"
AUTHENTICATION_BACKENDS = ["accounts.backends.ConstantTimeBackend", "accounts.backends.ClearanceBackend"]
AUTH_PASSWORD_VALIDATORS = [
    {"NAME": f"django.contrib.auth.password_validation.{name}"}
    for name in (
        "UserAttributeSimilarityValidator",
        "MinimumLengthValidator",
        "CommonPasswordValidator",
        "NumericPasswordValidator",
    )
] + [{"NAME": "accounts.passwords.OwnWordsValidator"}]
PASSWORD_RESET_TIMEOUT = 3600  # s; a mailed link
ACCOUNT_EMAIL_CONFIRMATION_EXPIRE_DAYS = 1
ACCOUNT_LOGIN_TIMEOUT = 24 * 3600  # s; who signed up waits for the mail as long as its link is good
LOGIN_URL, LOGIN_REDIRECT_URL = "account_login", "/"
ACCOUNT_LOGIN_METHODS = {"email", "username"}
ACCOUNT_SIGNUP_FIELDS = ["email*", "username*", "password1*"]
ACCOUNT_EMAIL_VERIFICATION = env.str("FARHAND_EMAIL_VERIFICATION", "mandatory")
ACCOUNT_CONFIRM_EMAIL_ON_GET = ACCOUNT_LOGOUT_ON_GET = False
ACCOUNT_LOGIN_ON_EMAIL_CONFIRMATION = ACCOUNT_PREVENT_ENUMERATION = True
ACCOUNT_EMAIL_SUBJECT_PREFIX = ""
ACCOUNT_ADAPTER = "accounts.adapter.AccountAdapter"
ACCOUNT_USERNAME_VALIDATORS = "accounts.handles.VALIDATORS"
ACCOUNT_FORMS = {"signup": "accounts.forms.SignupForm"}
MAIL_IN_BACKGROUND = True
# The movie of the day: the key that origin and edges share, the address at which the origin answers edges (with port 0
# the supervisor starts neither), and the ports of the edges that the supervisor starts.
BROADCAST_KEY = env.str("FARHAND_BROADCAST_KEY", "")
BROADCAST_GROUP = env.str("FARHAND_BROADCAST_GROUP", "239.8.1.30:5004")
BROADCAST_INTERFACE = env.str("FARHAND_BROADCAST_INTERFACE", "lo")
BROADCAST_HOST, BROADCAST_PORT = env.str("FARHAND_BROADCAST_HOST", "127.0.0.1"), env.int("FARHAND_BROADCAST_PORT", 8010)
BROADCAST_EDGES = env.list("FARHAND_BROADCAST_EDGES", cast=int, default=[])
SITE_NAME = env.str("FARHAND_SITE_NAME", "Farhand")  # the name of the site in mails
# Limits of attempts: "ip" is a network address (IPv6: its /64), "key" the account and the address together
# (accounts/adapter.py), or the mail address to which a mail goes.
ACCOUNT_RATE_LIMITS = {
    "login": "30/m/ip",
    "login_failed": "10/m/ip,60/h/ip,5/300s/key",
    "signup": "10/m/ip,60/h/ip",
    "reset_password": "10/m/ip,60/h/ip,3/600s/key",
    "reset_password_from_key": "20/m/ip",
    "confirm_email": "1/180s/key,60/h/ip",
    "change_password": "5/m/user",
    "manage_email": "10/m/user",
    "reauthenticate": "10/m/user",
}
# Limits of requests; "key" is the account, of guests the network address (portal/web/jobs/views.py).
RATE_LIMITS = {
    "survey": "30/m/ip,300/h/ip",
    "statistics": "120/m/ip",
    "ask": "30/5m/key",
    "practice": "30/m/ip,120/h/ip",  # turns of people without an account
    "push": "30/m/user",  # changes of which browsers are told
    "choices": "30/m/user",
    "code": "60/m/user",  # for the operator's stream
    "movie": "10/h/ip",
    "replay": "600/m/ip",
    "slices": "2400/m/ip",  # one replay at the greatest speed asks for about 100 a minute
}
ACCOUNT_DEFAULT_HTTP_PROTOCOL = "https" if PUBLIC else "http"
# uvicorn puts the address and scheme from a trusted proxy into the request, so that REMOTE_ADDR is right
# everywhere; nothing else reads X-Forwarded-For or X-Forwarded-Proto
try:
    TRUSTED_PROXIES = proxy_networks(env.list("FARHAND_TRUSTED_PROXIES", default=[]))
except ValueError as error:
    raise ImproperlyConfigured(str(error)) from error
ALLAUTH_TRUSTED_PROXY_COUNT = 0

EMAIL_CONFIG = read_url("EMAIL_URL", lambda: env.email_url("EMAIL_URL", default="consolemail://"))
vars().update(EMAIL_CONFIG)
EMAIL_TIMEOUT = 20  # s, for each answer of the mail server
DEFAULT_FROM_EMAIL = env.str("DEFAULT_FROM_EMAIL", "Farhand <farhand@localhost>")

ALERTS = {
    "AFTER_S": env.int("FARHAND_ALERT_AFTER_S", 300), "PRIVATE": env.bool("FARHAND_ALERT_PRIVATE", False),
    "WEBHOOK": env.str("FARHAND_ALERT_WEBHOOK", ""), "SECRET": env.str("FARHAND_ALERT_SECRET", ""),
}  # fmt: skip

# Web Push: `KEY` is the private key of the installation, 32 bytes in base64url; without `ON` no browser is told.
PUSH = {
    "ON": env.bool("FARHAND_PUSH", True), "PRIVATE": env.bool("FARHAND_PUSH_PRIVATE", False),
    "KEY": env.str("FARHAND_PUSH_KEY", "") or kept_secret(VAR / "push_key", new_push_key),
}  # fmt: skip

FORMAT_MODULE_PATH = "portal.web.formats"

STATIC_URL = "/static/"
STATIC_ROOT = VAR / "static"
STATIC_ROOT.mkdir(parents=True, exist_ok=True)
STATICFILES_DIRS = [("app", FRONTEND_DIST), ("farhand", FRONTEND_DIST / "farhand")] if FRONTEND_DIST.exists() else []
STATICFILES_FINDERS = [
    "django.contrib.staticfiles.finders.FileSystemFinder",
    "django.contrib.staticfiles.finders.AppDirectoriesFinder",
    "portal.web.consoles.files.Finder",
]
DJANGO_VITE = {
    "default": {
        "dev_mode": False,
        "static_url_prefix": "app",
        "manifest_path": FRONTEND_DIST / ".vite" / "manifest.json",
    }
}
WHITENOISE_USE_FINDERS = True
WHITENOISE_AUTOREFRESH = False
WHITENOISE_ALLOW_ALL_ORIGINS = False
MEDIA_URL = "/media/"
MEDIA_ROOT = Path(env.str("FARHAND_MEDIA", str(VAR / "media")))
FRAME_KEEP_DAYS = env.int("FARHAND_FRAME_KEEP_DAYS", 30)
RECORDING = {  # sizes in MB of 1,000,000 bytes
    "MB": env.int("FARHAND_RECORDING_MB", 64),  # of one turn or job
    "LIMIT_MB": env.int("FARHAND_RECORDINGS_MB", 4000),  # of a robot together
    "KEEP_DAYS": env.int("FARHAND_RECORDING_KEEP_DAYS", 30),
    "FREE_MB": env.int("FARHAND_RECORDING_FREE_MB", 1000),  # less free on the disk: nothing is recorded
    "MOVIE_KEEP_DAYS": env.int("FARHAND_MOVIE_KEEP_DAYS", 3),
    "MOVIES_MB": env.int("FARHAND_MOVIES_MB", 4000),  # all together; the oldest are removed first
}

CONTENT_SECURITY_POLICY = {
    "DIRECTIVES": {
        "default-src": [SELF],
        "script-src": [SELF],
        "worker-src": [SELF],
        "style-src": [SELF],
        "img-src": [SELF, "blob:", "data:"],
        "connect-src": [SELF],
        "font-src": [SELF],
        "object-src": [NONE],
        "base-uri": [NONE],
        "form-action": [SELF],
        "frame-ancestors": [NONE],
    }
}
CSRF_FAILURE_VIEW = "portal.web.pages.errors.csrf_failure"
X_FRAME_OPTIONS = "DENY"
SECURE_CONTENT_TYPE_NOSNIFF = True
SECURE_REFERRER_POLICY = "same-origin"
SECURE_CROSS_ORIGIN_OPENER_POLICY = "same-origin"
MESSAGE_STORAGE = "django.contrib.messages.storage.session.SessionStorage"  # no cookie of its own
SESSION_ENGINE = "accounts.sessions"
SESSION_COOKIE_HTTPONLY = True
SESSION_COOKIE_SAMESITE = "Lax"
CSRF_COOKIE_HTTPONLY = False
DATA_UPLOAD_MAX_MEMORY_SIZE = 1_000_000
if PUBLIC:
    SECURE_SSL_REDIRECT = True
    SECURE_HSTS_SECONDS = 31_536_000
    SECURE_HSTS_INCLUDE_SUBDOMAINS = True
    SECURE_HSTS_PRELOAD = True
    SESSION_COOKIE_SECURE = True
    CSRF_COOKIE_SECURE = LANGUAGE_COOKIE_SECURE = True
    SESSION_COOKIE_NAME, CSRF_COOKIE_NAME = "__Host-sessionid", "__Host-csrftoken"

# shared by all web processes: attempts are counted here
CACHES = {
    "default": {
        "BACKEND": "portal.edge.cache.SharedCache",
        "LOCATION": REDIS_URL,
        "KEY_PREFIX": "limits",
        "OPTIONS": {
            "serializer": "portal.edge.cache.Plain",
            "socket_timeout": REDIS_TIMEOUT_S,
            "socket_connect_timeout": REDIS_TIMEOUT_S,
        },
    }
}

LOGGING = {
    "version": 1,
    "disable_existing_loggers": False,
    "formatters": {
        "line": {"()": "portal.logs.lines.Line", "format": "%(asctime)s %(levelname)s %(name)s: %(message)s"}
    },
    "handlers": {"console": {"class": "portal.logs.outlet.Console", "formatter": "line"}},
    "root": {"handlers": ["console"], "level": env.str("LOG_LEVEL", "INFO")},
    "loggers": {
        "celery": {"level": "WARNING"},
        "celery.beat": {"level": "ERROR"},
        "django.request": {"level": "ERROR"},
        "uvicorn.access": {"level": "WARNING"},
        # Django's handlers on these, and those that Celery adds to loggers without any, would write text of strangers
        # unescaped and of any length, and would wait for a slow reader of the log.
        "django": {"level": "INFO"},
        "django.server": {"propagate": True},
        "celery.task": {"handlers": ["console"], "propagate": False},
        "multiprocessing": {"handlers": ["console"], "propagate": False},
    },
}

OPERATORS_PORT = env.int("FARHAND_OPERATORS_PORT", 0)  # of a second web process, for operators' streams; 0: none

# The limits of one network address (IPv6: its /64) in a web process, and of one request.
LIMITS: dict[str, Any] = {
    "SOCKETS": env.int("FARHAND_SOCKETS_PER_ADDRESS", 1000),
    "SOCKETS_OF_ACCOUNT": env.int("FARHAND_SOCKETS_PER_ACCOUNT", 20),  # beside operators' streams
    "OPERATORS": env.int("FARHAND_OPERATOR_SOCKETS_PER_ADDRESS", 50),
    "REQUESTS": env.int("FARHAND_REQUESTS_PER_ADDRESS", 300),
    "PAGES": env.int("FARHAND_PAGES_AT_ONCE", 2),  # rendered at a time in a web process
    "CONNECTIONS": env.int("FARHAND_CONNECTIONS_PER_ADDRESS", 2000),
    "VIEWERS": env.int("FARHAND_VIEWERS_PER_ROBOT", 4000),  # strangers; people who are signed in always may watch
    "COMPOSITES": env.int("FARHAND_COMPOSITES_PER_ADDRESS", 6),
    "COMPOSITE_VIEWERS": env.int("FARHAND_COMPOSITE_VIEWERS", 60),  # of a robot in a web process, as in the paper
    "HEAD_S": env.float("FARHAND_HEAD_S", 10.0),
    "BODY_S": env.float("FARHAND_BODY_S", 20.0),
    "READ_S": env.float("FARHAND_READ_S", 60.0),
    "BODY": env.int("FARHAND_BODY", 256_000),
    "STAFF_BODY": 1_000_000,
    "STAFF_BODY_S": 60.0,
}
if LIMITS["PAGES"] < 1:
    raise ImproperlyConfigured("FARHAND_PAGES_AT_ONCE must be at least 1; with less no page would ever be rendered.")

# The rules of turns; some have a field on the admin page of a robot, which overrides them.
FARHAND = {
    "OFFER_S": env.int("FARHAND_OFFER_S", 30),
    "TURN_S": env.int("FARHAND_TURN_S", 300),
    "COUNTDOWN_S": env.int("FARHAND_COUNTDOWN_S", 60),
    "RECONNECT_S": env.int("FARHAND_RECONNECT_S", 20),
    "IDLE_S": env.int("FARHAND_IDLE_S", 120),
    "PRESENCE_S": env.int("FARHAND_PRESENCE_S", 90),
    "CLASSIC_OFFER_S": env.int("FARHAND_CLASSIC_OFFER_S", 90),
    "CLASSIC_IDLE_S": env.int("FARHAND_CLASSIC_IDLE_S", 180),
    "CLASSIC_PRESENCE_S": env.int("FARHAND_CLASSIC_PRESENCE_S", 90),
    "QUIZ_PAUSE_S": env.int("FARHAND_QUIZ_PAUSE_S", 30),
    "QUIZ_PAUSE_MAX_S": env.int("FARHAND_QUIZ_PAUSE_MAX_S", 86_400),
    "QUIZ_QUESTIONS": env.int("FARHAND_QUIZ_QUESTIONS", 5),
    "LOG_EDIT_S": env.int("FARHAND_LOG_EDIT_S", 900),
    "LEASE_S": env.float("FARHAND_LEASE_S", 3.0),
    "REDIS_GONE_S": env.float("FARHAND_REDIS_GONE_S", 1.5),
}
