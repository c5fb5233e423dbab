"""What is said of a guest that failed: its name, the reason, and what it wrote to stderr."""

from tracker.errors import TrackingError


class ExternalTrackerFailed(TrackingError):
    """A guest that could not be set up or started, failed, took too long or wrote rubbish.

    guest: its name. stderr: the end of what it said, "" for nothing; the message does not have it.
    what: what the message calls it.
    """

    def __init__(self, guest: str, reason: str, stderr: str = "", what: str = "guest") -> None:
        super().__init__(f"{what} {guest}: {reason}")
        self.guest = guest
        self.stderr = stderr
