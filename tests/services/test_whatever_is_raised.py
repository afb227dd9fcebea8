"""Any error of a driver's or a camera's library leads to a sentence and a next attempt, and never ends the owner."""

import threading
from contextlib import suppress

import av
import numpy as np
import pytest

from robots import bus, services
from robots.kit.contract.errors import CameraFault, GrantOver, HardwareFault, MotionHeld, NotCalibrated, NotPermitted
from robots.kit.contract.session import Outcome, RobotState, Session
from robots.models import Incident, Robot
from tests.conftest import wait_for
from tests.raised import ALL, ORDINARY, name
from tests.services.owner import made_owner
from workers.door import Door, GuardedSession
from workers.media import camera as cameras
from workers.media import source
from workers.robot import calibration as calibrate
from workers.robot.machine import Machine

REST = RobotState(0.0, (0.0,) * 7, (0.0,) * 6, False, True)


class Broken(Session):
    """A driver whose methods named in `broken` raise `error`, the constructor too."""

    broken, error, wrong = (), ValueError("x"), None

    def __init__(self, *given):
        super().__init__("", {})
        self.done = []
        self._do("made", None)

    def _do(self, what, answer):
        if what != "made":
            self.done.append(what)
        if what in type(self).broken:
            if type(self).wrong is not None:
                return type(self).wrong
            raise type(self).error
        return answer

    def connect(self):
        return self._do("connect", self.keep(REST))

    def state(self):
        return self._do("state", REST)

    def execute(self, kind, args, permit, on_stage):
        permit()
        on_stage("sent")
        on_stage("acknowledged")
        return self._do("execute", Outcome({}, REST))

    def hold(self):
        return self._do("hold", REST)

    def close(self):
        self._do("close", None)

    def recover(self, permit):
        permit()
        return self._do("recover", REST)

    def picture(self, view, seconds):
        return self._do("picture", b"")


def broken(*what, error=None, wrong=None):
    return type("Broken", (Broken,), {"broken": what, "error": error, "wrong": wrong})


def calls(session):
    return {
        "connect": session.connect, "state": session.state, "hold": session.hold, "picture": lambda: session.picture("", 1.0),
        "execute": lambda: session.execute("ready", {}, lambda: None, lambda _: None),
        "recover": lambda: session.recover(lambda: None),
    }  # fmt: skip


@pytest.mark.parametrize("error", ALL, ids=name)
def test_every_call_of_a_driver_ends_in_a_sentence(error):
    for what, call in calls(
        GuardedSession(broken("connect", "state", "hold", "execute", "recover", "picture", error=error))
    ).items():
        with pytest.raises(HardwareFault) as told:
            call()
        text = str(told.value)
        assert text.startswith(f"The robot's driver failed: {name(error)}"), (what, text)
        assert text.endswith(".")
        assert "S3cret" not in text
        assert len(text) < 300
    GuardedSession(broken("close", error=error)).close()


@pytest.mark.parametrize("error", ALL, ids=name)
def test_a_driver_that_cannot_be_made_is_made_again_at_the_next_attempt(error):
    kind = broken("made", error=error)
    session = GuardedSession(kind)
    for call in calls(session).values():
        with pytest.raises(HardwareFault, match=r"The robot's driver failed"):
            call()
    assert session.latest() is None
    session.close()
    kind.broken = ()
    assert session.connect() is REST
    assert session.latest() is REST


def test_a_driver_that_cannot_connect_for_such_an_error_is_closed_and_made_anew():
    made = []

    def make():
        made.append(broken(*(() if made else ("connect",)), error=RuntimeError("can't start new thread"))())
        return made[-1]

    session = GuardedSession(make)
    with pytest.raises(HardwareFault, match="can't start new thread"):
        session.connect()
    assert made[0].done == ["connect", "close"]
    assert session.connect() is REST
    assert len(made) == 2


def test_two_threads_make_one_driver():
    made, both, making = [], threading.Barrier(2), threading.Event()

    def make():
        made.append(broken()() if made else None)
        if made[-1] is None:
            raise OSError("not yet")
        making.wait(0.2)  # so that the other thread comes meanwhile, too
        return made[-1]

    session = GuardedSession(make)

    def call(what):
        both.wait()
        what()

    threads = [threading.Thread(target=call, args=(what,)) for what in (session.connect, session.hold)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 2


@pytest.mark.parametrize("error", [ValueError("x"), SystemExit(1)])
def test_a_driver_that_cannot_tell_what_it_kept_has_told_nothing(monkeypatch, error):
    def latest(self):
        raise error

    kind = broken()
    monkeypatch.setattr(kind, "latest", latest, raising=False)
    assert GuardedSession(kind).latest() is None


@pytest.mark.parametrize("wrong", [7, "x", (), object()])
def test_what_a_driver_must_not_return_is_a_fault(wrong):
    for call in list(
        calls(GuardedSession(broken("connect", "state", "hold", "execute", "recover", wrong=wrong))).values()
    ):
        if "picture" not in call.__qualname__ and call.__name__ != "<lambda>":
            with pytest.raises(HardwareFault, match="instead of RobotState"):
                call()
    with pytest.raises(HardwareFault, match="instead of Outcome"):
        GuardedSession(broken("execute", wrong=wrong)).execute("ready", {}, lambda: None, lambda _: None)


def test_a_driver_that_fails_in_a_command_is_held():
    kind = broken("execute", "recover", error=ValueError("x"))
    for what in ("execute", "recover"):
        session = GuardedSession(kind)
        with pytest.raises(HardwareFault, match=r"ValueError: x\. The robot was held\."):
            calls(session)[what]()
        assert session._session.done[-1] == "hold"
    kind.broken = ("execute", "hold")
    with pytest.raises(HardwareFault, match="could not be held: look at it"):
        calls(GuardedSession(kind))["execute"]()


@pytest.mark.parametrize(
    "ours", [GrantOver("It is over."), MotionHeld("A stop came first."), ValueError("ours"), SystemExit(3)], ids=name
)
@pytest.mark.parametrize("where", ["permit", "on_stage"])
def test_what_the_owner_itself_raises_passes_as_it_is(ours, where):
    def fail(*_):
        raise ours

    session = GuardedSession(broken())
    told = {"permit": lambda: None, "on_stage": lambda _: None} | {where: fail}
    with pytest.raises(type(ours)) as found:
        session.execute("ready", {}, **told)
    assert found.value is ours
    assert "hold" not in session._session.done


def test_sentences_of_a_driver_pass_as_they_are():
    session = GuardedSession(broken("execute", "state", error=NotPermitted("Not now.")))
    with pytest.raises(NotPermitted, match=r"^Not now\.$"):
        calls(session)["execute"]()
    with pytest.raises(HardwareFault, match=r"NotPermitted: Not now"):  # no rule forbids to ask
        session.state()


def test_a_person_at_the_keyboard_is_obeyed():
    with pytest.raises(KeyboardInterrupt), Door(CameraFault, "x").open():
        raise KeyboardInterrupt


def test_the_same_failure_is_logged_once(caplog):
    door = Door(CameraFault, "The camera failed")
    for error in (ValueError("a"), ValueError("b"), TypeError("c"), None, TypeError("d")):
        with suppress(CameraFault), door.open():
            if error is not None:
                raise error
    said = [record.getMessage() for record in caplog.records]
    assert [text.partition(": ")[2] for text in said] == ["ValueError: a.", "TypeError: c.", "TypeError: d."]


def test_an_error_that_cannot_say_what_it_is_has_a_sentence_too():
    class Mute(Exception):
        def __str__(self):
            raise RuntimeError("no words")

        strerror = property(__str__)

    with (
        pytest.raises(CameraFault, match=r"^The camera failed: Mute\.$"),
        Door(CameraFault, "The camera failed").open(),
    ):
        raise Mute


# the whole owner


@pytest.fixture
def opened(robot, people, monkeypatch):
    """An owner; `opened.kind.broken` and `.error` say what its driver raises from now on."""
    kind = broken()
    machine = Machine(lambda name, *given: kind(name, *given), lambda *_: Good())
    made = made_owner(robot, people, machine=machine)
    made.owned.renew_driver()
    made.kind = kind
    monkeypatch.setattr(made.threads, "begin", lambda *_: None)
    return made


@pytest.mark.service
@pytest.mark.django_db(transaction=True)
@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_an_owner_tells_it_and_connects_when_that_is_over(opened, people):
    owner, kind = opened, opened.kind
    for error in ALL:
        for what in ("connect", "state", "hold", "execute", "made"):
            kind.broken, kind.error = (what,), error
            if what == "made":
                owner.owned.renew_driver()
            owner.connection.later(0.0)
            owner.connection.mend()
            if what in ("connect", "made"):
                assert not owner.connection.connected
                assert Robot.objects.get().reason.startswith("The robot's driver failed"), what
            owner.stopping._hold()
            if what == "execute":
                command = services.issue(
                    owner.owned.robot.slug, people["ada"], "ready", {}, next(SEQ), owner.owned.now()
                ).command
                owner.motion.run_one(command)
                command.refresh_from_db()
                assert command.state == "failed"
                assert "The robot was held" in command.reason
                assert "S3cret" not in command.reason
            kind.broken = ()
            owner.connection.later(0.0)
            owner.connection.mend()
            assert owner.connection.connected
    assert not any("S3cret" in str(vars(row)) for row in (*Incident.objects.all(), *Robot.objects.all()))


SEQ = iter(range(1, 10_000))


@pytest.mark.service
@pytest.mark.django_db(transaction=True)
def test_a_calibration_that_fails_is_told(opened, monkeypatch):
    for error in ALL:

        def procedure(session, settle, permit, error=error):
            raise error

        monkeypatch.setattr(calibrate, "function", lambda path, procedure=procedure: procedure)
        with pytest.raises(NotCalibrated, match="The calibration failed"):
            calibrate.calibrate_and_keep(opened.owned, opened.pictures, lambda: None)


# cameras


class Good:
    def grab(self, exposure_s):
        return np.zeros((165, 192), np.uint8)

    def close(self):
        pass


@pytest.fixture
def camera(robot):
    def opened(*where):
        return made.where(*where)

    made = cameras.Camera(robot, 0, "", lambda view, seconds: None, opened=opened)
    yield made
    made.close()


@pytest.mark.django_db
def test_every_picture_ends_in_a_sentence_and_the_next_is_tried_anew(robot, camera):
    class Source:
        def grab(self, exposure_s):
            raise self.error

        def close(self):
            raise self.error

    for error in ALL:
        Source.error = error

        def unopened(*_, error=error):
            raise error

        for where in (unopened, lambda *_: Source()):
            camera.where = where
            with pytest.raises(CameraFault, match="The camera failed") as told:
                camera.grab(0.01)
            assert "S3cret" not in str(told.value)
            assert camera._source is None
    camera.where = lambda *_: Good()
    assert camera.grab(0.01).shape == (165, 192)


@pytest.mark.service
@pytest.mark.django_db(transaction=True)
def test_pictures_go_on_without_what_corrects_them(opened, monkeypatch):
    class Corrector:
        error = None

        def correct(self, picture):
            if self.error is None:
                return None, self
            raise self.error

    pictures = type(opened.pictures)(opened.owned.robot, opened.clock, opened.owned.picture, lambda *_: Good())
    pictures._brightness = Corrector()
    everything = frozenset(bus.demand._possible(0))
    monkeypatch.setattr(bus, "demands", lambda *_: everything)
    for error in (None, *ALL):
        Corrector.error = error
        assert pictures.live_once(REST) is True
        with pytest.raises(CameraFault, match="brightness failed"):
            pictures.still(REST, None, None)


def test_a_stream_goes_on_after_whatever_its_library_raises(monkeypatch):
    raised, errors = [], iter(ORDINARY)

    def refuse(*_, **__):
        error = next(errors, None)
        if error is None:
            raise OSError(5, "done")
        raised.append(error)
        raise error

    monkeypatch.setattr(av, "open", refuse)
    monkeypatch.setattr(source, "AGAIN_S", 0.0)
    camera = source.StreamCamera("rtsp://admin:S3cret@127.0.0.1/live")
    wait_for(lambda: len(raised) == len(ORDINARY), 60, "every error")
    camera.close()
    assert "S3cret" not in camera._error
