"""Django's PostgreSQL backend with a limit for every wait.

If a server is cut off in the middle of an answer (a cable, a frozen host, a firewall that forgot the connection), TCP
may wait for hours, and so would a page or a robot's owner. Here a statement that is not answered within `wait_s` ends
with an OperationalError, and its connection is closed.
"""

from typing import Any

import psycopg
from django.db.backends.postgresql import base
from psycopg.pq import TransactionStatus

LOOK_S = 0.1


class LimitedConnection(psycopg.Connection[Any]):
    """A connection that waits at most `wait_s` (s)."""

    wait_s = 10.0

    def wait(self, gen: Any, interval: float = LOOK_S, timeout: float | None = None) -> Any:
        """Run one exchange with the server. Raises OperationalError after the limit."""
        try:
            return super().wait(gen, interval, timeout or self.wait_s)
        except psycopg.OperationalError as error:
            if self.pgconn.transaction_status == TransactionStatus.ACTIVE:  # whether it was carried out is not known
                self.pgconn.finish()
                raise psycopg.OperationalError("the database did not answer in time") from error
            raise


class DatabaseWrapper(base.DatabaseWrapper):
    """Django's, with these connections."""

    def get_connection_params(self) -> dict[str, Any]:
        """Remove our own option from those for libpq."""
        params: dict[str, Any] = super().get_connection_params()
        self._wait_s = float(params.pop("wait_s", LimitedConnection.wait_s))
        return params

    def get_new_connection(self, conn_params: dict[str, Any]) -> Any:
        """Connect, and limit every wait from now on."""
        connection = super().get_new_connection(conn_params)
        connection.__class__ = LimitedConnection
        connection.wait_s = self._wait_s
        return connection
