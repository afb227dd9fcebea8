"""Sessions in the database as Django keeps them; the statement that reads one, at every page, is made once."""

from typing import Any

from django.contrib.sessions.backends import db
from django.contrib.sessions.models import Session
from django.db.models import CharField, DateTimeField
from django.utils import timezone

from robots.prepared import Prepared, Slot

_OPEN: Prepared[Session] = Prepared(
    lambda: Session.objects.filter(
        session_key=Slot("key", CharField()), expire_date__gt=Slot("now", DateTimeField())
    )
)  # fmt: skip


class SessionStore(db.SessionStore):
    """Django's, under its name, with which the data are signed."""

    def _get_session_from_db(self) -> Any:
        found = _OPEN.first(key=self.session_key, now=timezone.now())
        if found is None:
            self._session_key = None
        return found
