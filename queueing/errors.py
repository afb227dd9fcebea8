"""What the queue answers when it says no."""


class QueueError(Exception):
    """Root; `str()` is a sentence for the person."""

    code = "queue"


class NotCleared(QueueError):
    """The clearance test comes first."""

    code = "not_cleared"


class NotYourTurn(QueueError):
    """There is no offer or turn of this person's."""

    code = "not_your_turn"


class RobotUnavailable(QueueError):
    """The robot is not offered now."""

    code = "unavailable"


class TooManyJobs(QueueError):
    """As many jobs as one may have are open."""

    code = "too_many_jobs"


class NotYourJob(QueueError):
    """The job is somebody else's."""

    code = "not_your_job"
