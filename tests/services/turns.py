"""Turns for tests: from the place in the queue to control."""

from queueing import services as queue


def drive(robot, person, now, **more):
    """Let the person join, be offered the robot and accept it; `more` goes to `join`. Return the turn."""
    queue.join(robot, person, now, **more)
    queue.tick(now)
    return queue.accept(robot, person, now)
