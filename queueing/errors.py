"""Errors of the queue, each with a sentence for the person."""


class QueueError(Exception):
    """Base class; `str()` is a sentence for the person."""

    code = "queue"


class NotCleared(QueueError):
    """The person has not passed the clearance test."""

    code = "not_cleared"


class NotYourTurn(QueueError):
    """The person has no offer or turn."""

    code = "not_your_turn"


class RobotUnavailable(QueueError):
    """The robot is not offered now."""

    code = "unavailable"


class TooManyJobs(QueueError):
    """The person has as many open jobs as allowed."""

    code = "too_many_jobs"


class TooOften(QueueError):
    """The person, or the guests of a network address, have asked for too many jobs lately."""

    code = "too_often"


class NotYourJob(QueueError):
    """The job is another person's."""

    code = "not_your_job"
