"""What people do in many tests: sign in, and take a turn."""

from django.test import Client

from queueing import services as queue


def signed_in(user=None, **options):
    """Return a browser in which the person is signed in; a stranger's browser without a person."""
    client = Client(**options)
    if user is not None and user.is_authenticated:
        client.force_login(user)
    return client


def give_turn(robot, person, now):
    """Let the person join the queue, be offered the robot and accept it; return the turn."""
    queue.join(robot, person, now)
    queue.tick(now)
    return queue.accept(robot, person, now)
