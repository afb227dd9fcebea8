"""Staff are told once that a robot needs them and once that it is over, whatever goes wrong."""

import smtplib
from datetime import timedelta

import pytest
from django.core import mail
from django.test import Client

from portal.web.alerts import sending
from portal.web.alerts.following import follow
from portal.web.alerts.models import Alert, AlertChoice, AlertMessage
from portal.web.alerts.sending import send_due
from robots.models import Incident, Lease, Program, Robot
from robots.services import note_outages, programs
from robots.services.incidents import TRANSIENT, close_incident, incident
from robots.states import Cycle
from tests.services.alerts import rounds, stop
from tests.services.alerts import staffed as staffed

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def subjects():
    return [(one.to[0], one.subject) for one in mail.outbox]


NEEDS, OVER = (
    ("kim@example.org", "Mercury (simulated) needs staff"),
    ("kim@example.org", "Mercury (simulated) no longer needs staff"),
)


def test_a_stop_that_stays_is_told_once_and_its_end_once(robot, clock):
    stop(robot)
    rounds(clock, 10)
    assert subjects() == [NEEDS]
    stop(robot, False)
    rounds(clock, 10)
    assert subjects() == [NEEDS, OVER]
    assert "https://robots.example.org/admin/robots/robot/" in mail.outbox[0].body
    assert "https://robots.example.org/me/" in mail.outbox[0].body


def test_a_stop_that_its_operator_releases_at_once_is_told_to_nobody(robot, clock):
    stop(robot)
    rounds(clock, 0.5)
    stop(robot, False)
    rounds(clock, 10)
    assert mail.outbox == []
    assert not Alert.objects.exists()


def test_a_lost_worker_is_told_after_five_minutes_and_a_locked_out_robot_not(robot, clock):
    Lease.objects.update(expires_at=clock.now())
    rounds(clock, 4.5)
    assert mail.outbox == []
    rounds(clock, 1.5)
    assert subjects() == [NEEDS]
    assert "worker does not answer" in mail.outbox[0].body
    Robot.objects.update(cycle=Cycle.LOCKED_OUT)
    rounds(clock, 5)
    assert subjects() == [NEEDS, OVER]


def test_a_faulty_robot_says_why(robot, clock):
    Robot.objects.update(cycle=Cycle.FAULT, reason="The arm does not move.")
    rounds(clock, 6)
    assert "Faulty. The arm does not move." in mail.outbox[0].body


def test_an_incident_is_told_at_once_and_others_of_its_kind_with_it(robot, clock, people):
    for n in range(20):
        incident(robot, "silent", f"It was silent {n}.", clock.now())
        rounds(clock, 0.5)
    assert subjects() == [NEEDS]
    for one in Incident.objects.all():
        close_incident(one, people["kim"])
    rounds(clock, 5)
    assert subjects() == [NEEDS, OVER]


@pytest.mark.parametrize("remedy", TRANSIENT)
def test_what_is_tried_again_and_ends_within_a_minute_is_told_to_nobody(robot, clock, people, remedy):
    incident(robot, "camera", "The camera has not started yet.", clock.now(), remedy=remedy)
    rounds(clock, 0.5)
    close_incident(Incident.objects.get(), people["kim"])
    rounds(clock, 5)
    assert not mail.outbox
    incident(robot, "camera", "The camera has not started yet.", clock.now(), remedy=remedy)
    rounds(clock, 2)
    assert subjects() == [NEEDS]


def test_an_incident_of_another_kind_is_another_alert(robot, clock):
    incident(robot, "silent", "It was silent.", clock.now())
    incident(robot, "limit", "It was at its limit.", clock.now())
    rounds(clock, 1)
    assert len(mail.outbox) == 2


def test_a_need_that_comes_and_goes_is_one_alert(robot, clock):
    for _ in range(30):
        stop(robot)
        rounds(clock, 1.5)
        stop(robot, False)
        rounds(clock, 1)
    rounds(clock, 5)
    assert subjects() == [NEEDS, OVER]


def test_a_need_that_comes_back_every_ten_minutes_is_told_rarely(robot, clock):
    for _ in range(12):  # two hours
        stop(robot)
        rounds(clock, 5)
        stop(robot, False)
        rounds(clock, 5)
    assert len(mail.outbox) <= 3, subjects()


def test_programs_that_wait_for_a_review_for_a_day_are_told(robot, people, clock):
    program = Program.objects.create(
        robot=robot, author=people["ada"], name="p", text="down", shared=True, changed_at=clock.now()
    )
    rounds(clock, 2)
    assert mail.outbox == []
    clock.go(86_400)
    rounds(clock, 2)
    assert subjects() == [NEEDS]
    program.delete()
    rounds(clock, 5)
    assert subjects() == [NEEDS, OVER]


def test_a_robot_that_is_switched_off_needs_nobody(robot, clock):
    stop(robot)
    rounds(clock, 2)
    Robot.objects.update(enabled=False)
    rounds(clock, 5)
    assert subjects() == [NEEDS, OVER]


def test_two_processes_and_restarts_tell_it_once(robot, clock, monkeypatch):
    stop(robot)
    found = Alert.objects.filter(ended_at=None)
    for _ in range(20):
        stale = list(found)  # the other process has read these rows before this one acts
        follow(clock.now())
        with monkeypatch.context() as other:
            other.setattr(
                Alert.objects,
                "filter",
                lambda stale=stale, **kwargs: (
                    stale if [*kwargs] == ["ended_at"] else Alert.objects.get_queryset().filter(**kwargs)
                ),
            )
            follow(clock.now())
        send_due(clock.now())
        send_due(clock.now())
        clock.go(30)
    assert subjects() == [NEEDS]
    assert AlertMessage.objects.count() == 1


def test_a_mail_that_another_process_sends_is_left_to_it(robot, clock, monkeypatch):
    stop(robot)
    follow(clock.now())
    follow(clock.go(120))
    message = AlertMessage.objects.get()
    assert sending._send(message, clock.now())
    assert not sending._send(message, clock.now()), "as it was read before the other began"
    assert subjects() == [NEEDS]


def test_a_mail_whose_process_was_killed_is_not_sent_again(robot, clock):
    stop(robot)
    follow(clock.now())
    follow(clock.go(120))
    AlertMessage.objects.update(state="sending", next_at=clock.now() + sending.TAKEN_FOR_LOST)
    rounds(clock, 10)
    assert mail.outbox == []
    assert AlertMessage.objects.get().state == "unknown"


class Server:
    """A mail server that fails so many times, and then takes the mails."""

    def __init__(self, *fails, at="open"):
        self.fails, self.at = list(fails), at

    def _maybe(self, step):
        if step == self.at and self.fails:
            raise self.fails.pop(0)

    def open(self):
        self._maybe("open")

    def send_messages(self, messages):
        self._maybe("send")
        mail.outbox.extend(messages)
        return len(messages)

    def close(self):
        pass


def test_a_mail_server_that_is_away_is_asked_again_later_and_later(robot, clock, monkeypatch):
    server = Server(*[ConnectionRefusedError("no")] * 3)
    monkeypatch.setattr(sending, "get_connection", lambda: server)
    stop(robot)
    rounds(clock, 3)
    assert mail.outbox == []
    assert "cannot be reached" in AlertMessage.objects.get().error
    stop(robot, False)
    rounds(clock, 12)
    assert subjects() == [NEEDS, OVER], "in order, though it was over before the first was sent"


def test_a_refused_mail_is_sent_again_and_a_doubtful_one_not(robot, clock, monkeypatch):
    monkeypatch.setattr(sending, "get_connection", lambda: refused)
    refused = Server(smtplib.SMTPDataError(451, b"later"), at="send")
    stop(robot)
    rounds(clock, 5)
    assert subjects() == [NEEDS]
    stop(robot, False)
    refused.fails.append(TimeoutError("no answer"))
    rounds(clock, 15)
    assert subjects() == [NEEDS]
    assert sorted(AlertMessage.objects.values_list("state", flat=True)) == ["sent", "unknown"]


def test_after_some_tries_a_message_is_given_up(robot, clock, monkeypatch):
    monkeypatch.setattr(sending, "get_connection", lambda: Server(ConnectionRefusedError()))
    stop(robot)
    rounds(clock, 300, each_s=60)
    message = AlertMessage.objects.get()
    assert (message.state, message.tries) == ("failed", sending.TRIES)


def test_each_member_of_staff_chooses_and_others_are_not_told(robot, people, clock):
    client = Client()
    client.force_login(people["kim"])
    assert b"Tell me by e-mail when a robot needs staff" in client.get("/me/").content
    assert client.post("/me/alerts/", {}).status_code == 302
    assert AlertChoice.objects.get().by_mail is False
    stop(robot)
    rounds(clock, 5)
    assert mail.outbox == []
    assert client.post("/me/alerts/", {"by_mail": "on"}).status_code == 302
    other = Client()
    other.force_login(people["mod"])
    assert b"Tell me by e-mail when a robot needs staff" not in other.get("/me/").content
    assert other.post("/me/alerts/", {"by_mail": "on"}).status_code == 403


def test_who_is_no_longer_staff_is_not_told_that_it_is_over(robot, people, clock):
    stop(robot)
    rounds(clock, 5)
    people["kim"].is_staff = False
    people["kim"].save()
    stop(robot, False)
    rounds(clock, 5)
    assert subjects() == [NEEDS]


def test_alerts_that_are_long_over_are_deleted(robot, clock):
    stop(robot)
    rounds(clock, 3)
    stop(robot, False)
    rounds(clock, 5)
    clock.go(401 * 86_400)
    Lease.objects.update(expires_at=clock.now() + timedelta(days=9))
    rounds(clock, 1)
    assert not Alert.objects.exists()


def test_a_program_that_staff_declined_is_told_to_nobody(robot, people, admin_user, clock):
    program = Program.objects.create(
        robot=robot, author=people["ada"], name="p", text="down", shared=True, changed_at=clock.now()
    )
    programs.approve(program, admin_user, False)
    clock.go(86_400)
    rounds(clock, 5)
    assert mail.outbox == []


def test_an_outage_that_is_an_incident_too_is_told_once(robot, clock):
    Lease.objects.update(expires_at=clock.now())
    for _ in range(8):
        note_outages(clock.now())
        rounds(clock, 1)
    assert Incident.objects.count() == 1
    assert subjects() == [NEEDS]
    assert len(Alert.objects.all()) == 1


def test_a_mail_to_staff_is_in_the_language_of_its_receiver(robot, staffed, clock):
    type(staffed).objects.filter(pk=staffed.pk).update(language="de")
    stop(robot)
    rounds(clock, 10)
    stop(robot, False)
    rounds(clock, 10)
    begun, over = mail.outbox
    assert begun.subject.endswith("braucht das Personal")
    assert "Er wurde angehalten, und der Stopp ist nicht gelöst." in begun.body
    assert over.subject.endswith("braucht das Personal nicht mehr")
