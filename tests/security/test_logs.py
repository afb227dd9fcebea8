"""The content of the security log, and what it never contains."""

import logging
import os
import subprocess
import sys
import threading

import pytest
from allauth.account.models import EmailAddress

from portal.logs.lines import LINE, MESSAGE, TRACE, Line
from portal.logs.outlet import ROOM, Outlet
from tests.rig import ROOT, child_env
from tests.waiting import CEILING_S

FORGED = "a\r\n2027-01-15T08:00:00.250Z ERROR root: forged\x1b[2J\x9b\u2028\u202eb\ud800"
FORM = "%(asctime)s %(levelname)s %(name)s: %(message)s"


def record(text, *args, **more):
    return logging.LogRecord("farhand", logging.WARNING, __file__, 1, text, args, **{"exc_info": None, **more})


@pytest.mark.asvs("16.2.2", "16.2.4", "16.2.1")
def test_a_line_says_when_in_utc():
    made = record("it is so")
    made.created, made.msecs = 1_800_000_000.25, 250.0
    assert Line(FORM).format(made) == "2027-01-15T08:00:00.250Z WARNING farhand: it is so"


@pytest.mark.asvs("16.4.1", "1.3.10")
@pytest.mark.parametrize("text", ["a\nERROR root: forged", "a\r\nb", "a\x1b[2Jb", "\u2028b", "%s%n{0.__class__}"])
def test_what_a_stranger_wrote_begins_no_line(text):
    line = Line(FORM).format(record("refused: %s", text))
    assert len(line.splitlines()) == 1
    assert line.isprintable()


@pytest.mark.asvs("16.3.4")
def test_a_traceback_keeps_its_lines():
    try:
        raise ValueError("inside")
    except ValueError:
        text = Line(FORM).format(record("failed", exc_info=sys.exc_info()))
    assert "ValueError: inside" in text.splitlines()[-1]


def failed(make):
    """Return the lines of a record about what `make` raises."""
    try:
        make()
    except Exception:
        return Line(FORM).format(record("it failed", exc_info=sys.exc_info(), stack_info="Stack:\n  File x\r\n"))
    raise AssertionError("nothing was raised")


def simple():
    raise ValueError(FORGED)


def chained():
    try:
        simple()
    except ValueError as error:
        error.add_note(FORGED)
        raise KeyError(FORGED) from error


def grouped():
    raise ExceptionGroup(FORGED, [ValueError(FORGED), KeyError(FORGED), ExceptionGroup("more", [OSError(1, FORGED)])])


def unreadable():
    compile("\x1b[2J\u202e = '", FORGED, "exec")


def deep(n=500):
    return deep(n - 1) if n else simple()


@pytest.mark.asvs("16.4.1")
@pytest.mark.parametrize("make", [simple, chained, grouped, unreadable, deep])
def test_what_a_stranger_wrote_begins_no_line_of_a_traceback(make):
    text = failed(make)
    lines = text.split("\n")
    assert all(line.isprintable() for line in lines)
    assert all(line.startswith("  ") for line in lines[1:])
    assert len(text.encode()) <= MESSAGE + 2 * TRACE + 200
    if make in (simple, deep):
        assert "test_logs.py" in text, "where it was raised"


def test_a_line_that_another_handler_has_made_of_a_traceback_is_made_anew():
    try:
        simple()
    except ValueError:
        made = record("it failed", exc_info=sys.exc_info())
    logging.Formatter().format(made)
    assert "\r" in made.exc_text
    assert "\r" not in Line(FORM).format(made)


@pytest.mark.asvs("16.4.1")
@pytest.mark.parametrize(
    "text", ["a" * 10_000_000, "\x1b" * 10_000_000, "\U0001f916" * 1_000_000, "\u202e\n" * 1_000_000]
)
def test_a_record_is_short_whatever_it_is_about(text):
    def fail():
        raise ValueError(text)

    line = Line(FORM).format(record("refused: %s", text))
    assert len(line.encode()) <= MESSAGE + 100
    assert "left out" in line
    trace = failed(fail)
    assert len(trace.encode()) <= MESSAGE + 2 * TRACE + 200
    assert max(len(line.encode()) for line in trace.split("\n")) <= LINE + 100
    assert "in fail" in trace


HANDLERS = """
import logging, os, sys
os.environ["DJANGO_SETTINGS_MODULE"] = "portal.settings"
if sys.argv[1] == "web":
    from portal.run import serve
    serve.config("127.0.0.1", 0).load()
else:
    import django
    django.setup()
    from portal.celery import app
    app.log.setup("INFO", redirect_stdouts=True)
    print("printed\\x1b[2J", end="\\n")
evil = "a\\r\\nERROR forged \\x1b[2J" + "e" * 100_000
loggers = ["root", "django.request", "django.server", "uvicorn", "uvicorn.error", "asyncio", "celery.task.one", "py.warnings",
           "websockets.server", "concurrent.futures", "multiprocessing"]
for name in loggers:
    try:
        raise ValueError(evil)
    except ValueError:
        logging.getLogger(name).error("about %s: %s", name, evil, exc_info=True)
logging.getLogger("root").error("%d", evil)
"""


@pytest.mark.asvs("16.4.1")
@pytest.mark.parametrize("process", ["web", "celery"])
@pytest.mark.parametrize("debug", ["0", "1"])
def test_no_library_writes_into_the_log_by_its_own_way(process, debug):
    done = subprocess.run(
        [sys.executable, "-c", HANDLERS, process], cwd=ROOT, env=child_env(DEBUG=debug, LOG_LEVEL="INFO"),
        capture_output=True, timeout=CEILING_S,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    said = done.stderr.decode()
    assert not done.stdout
    assert all(line.isprintable() for line in said.split("\n"))
    for name in (
        "root",
        "django.request",
        "django.server",
        "uvicorn.error",
        "asyncio",
        "celery.task.one",
        "multiprocessing",
    ):
        assert said.count(f"Z ERROR {name}: about ") == 1, said[:3000]
    assert len(said) < 12 * (MESSAGE + TRACE + 500)
    assert said.splitlines()[-1] == "<string>:21 has logged what has no text: TypeError"


@pytest.mark.asvs("15.2.2")
def test_a_log_that_nobody_reads_takes_lines_at_once_and_says_later_how_many_were_left_out():
    ours, theirs = os.pipe()
    outlet = Outlet(theirs)
    line = "x" * 99
    for number in range(30_000):  # six times as much as waits
        outlet.write(f"{number:05} {line}"[:99])
    assert not outlet.flush(0.01)
    assert outlet._size <= ROOM
    outlet.write("the last one, for which there is no room")
    read, told, lost = b"", [], 0
    while len(told) + lost < 30_001:
        read += os.read(ours, 65_536)
        lines = read.decode().splitlines()[: read.count(b"\n")]
        told = [int(text[:5]) for text in lines if "left out" not in text]
        lost = sum(int(text.split()[0]) for text in lines if "left out" in text)
    assert len(told) + lost == 30_001
    assert lost > 10_000
    assert told == sorted(set(told)), "in order"
    outlet.write("again")
    assert outlet.flush(CEILING_S)
    assert os.read(ours, 100) == b"again\n"
    os.close(ours)
    os.close(theirs)


def test_lines_that_could_not_be_written_are_counted():
    ours, theirs = os.pipe()
    outlet = Outlet(theirs)
    os.close(ours)
    for _ in range(3):
        outlet.write("nobody reads it")
        assert outlet.flush(CEILING_S)
    assert outlet._lost == 3
    os.close(theirs)


def test_a_descriptor_that_another_process_has_made_non_blocking_loses_nothing():
    ours, theirs = os.pipe()
    os.set_blocking(theirs, False)
    outlet = Outlet(theirs)
    for number in range(2000):
        outlet.write(f"{number:04} " + "x" * 94)
    read = b""
    while len(read) < 200_000:
        read += os.read(ours, 65_536)
    assert [int(text[:4]) for text in read.decode().splitlines()] == list(range(2000))
    assert outlet.flush(CEILING_S)
    os.close(ours)
    os.close(theirs)


@pytest.mark.asvs("16.3.4")
def test_the_last_words_of_an_owner_are_written():
    """It ends without Python's own end, whatever its threads do."""
    script = "import django; django.setup(); import logging; from workers.process import wiring; logging.error('the last word'); wiring.end_at_once()"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, env=child_env(DJANGO_SETTINGS_MODULE="portal.settings"),
        capture_output=True, text=True, timeout=CEILING_S,
    )  # fmt: skip
    assert (done.returncode, done.stderr.count("ERROR root: the last word")) == (3, 1), done.stderr


def test_a_fork_writes_its_own_lines_and_no_others():
    """A fork has no threads, and may have been made while one of them held the lock."""
    ours, theirs = os.pipe()
    outlet = Outlet(theirs)
    outlet.write("parent")
    assert outlet.flush(CEILING_S)
    held, leave = threading.Event(), threading.Event()

    def hold():
        with outlet._changed:
            held.set()
            leave.wait(CEILING_S)

    holder = threading.Thread(target=hold)
    holder.start()
    held.wait(CEILING_S)
    child = os.fork()
    if not child:
        outlet.write("child")
        os._exit(0 if outlet.flush(CEILING_S) else 1)
    leave.set()
    holder.join()
    assert os.waitpid(child, 0)[1] == 0
    assert os.read(ours, 100) == b"parent\nchild\n"
    os.close(ours)
    os.close(theirs)


@pytest.mark.django_db
@pytest.mark.asvs("16.3.1", "16.2.5")
def test_signing_in_failing_and_out_are_told_without_what_was_typed(people, client, caplog):
    EmailAddress.objects.create(user=people["ada"], email="ada@example.org", verified=True, primary=True)
    with caplog.at_level(logging.INFO, "farhand.security"):
        client.post("/accounts/login/", {"login": "hunter2 typed here", "password": "a wrong one 77"})
        client.post("/accounts/login/", {"login": "ada", "password": "correct horse 42"})
        key = client.session.session_key
        client.post("/accounts/logout/")
    told = [r.getMessage() for r in caplog.records if r.name == "farhand.security"]
    assert [t.split(":")[0].split(" from")[0] for t in told] == ["sign-in failed", "signed in", "signed out"]
    assert f"account {people['ada'].pk} from 127.0.0.1" in told[1]
    for secret in ("hunter2", "a wrong one 77", "correct horse 42", key):
        assert secret not in caplog.text


@pytest.mark.django_db
@pytest.mark.asvs("16.3.2", "16.3.3")
def test_a_refused_request_is_told(people, client, caplog):
    client.force_login(people["ada"])
    with caplog.at_level(logging.INFO, "farhand.security"):
        assert client.get("/survey/results/").status_code == 403
    assert f"refused with 403: GET /survey/results/, account {people['ada'].pk} from 127.0.0.1" in caplog.text
