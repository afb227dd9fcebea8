"""Django's PostgreSQL backend with a limit to every wait.

A server that is cut off in the middle of an answer (a cable, a frozen host, a firewall that
forgot the connection) is noticed by nobody: TCP may wait for hours, and with it a page or a
robot's owner. Here a statement that is not answered within `wait_s` ends as an
OperationalError, and its connection is closed.
"""

from typing import Any

import psycopg
from django.db.backends.postgresql import base
from psycopg.pq import TransactionStatus

LOOK_S = 0.1


class PatientConnection(psycopg.Connection[Any]):
    """A connection that waits only so long."""

    wait_s = 10.0

    def wait(self, gen: Any, interval: float = LOOK_S, timeout: float | None = None) -> Any:
        """Run one exchange with the server. Raises OperationalError when its time is over."""
        try:
            return super().wait(gen, interval, timeout or self.wait_s)
        except psycopg.OperationalError as error:
            if self.pgconn.transaction_status == TransactionStatus.ACTIVE:  # nobody knows what became of it
                self.pgconn.finish()
                raise psycopg.OperationalError("the database did not answer in time") from error
            raise


class DatabaseWrapper(base.DatabaseWrapper):
    """Django's, whose connections are patient ones."""

    def get_connection_params(self) -> dict[str, Any]:
        """Take our own option out of libpq's."""
        params: dict[str, Any] = super().get_connection_params()
        self._wait_s = float(params.pop("wait_s", PatientConnection.wait_s))
        return params

    def get_new_connection(self, conn_params: dict[str, Any]) -> Any:
        """Connect, and limit what is waited for from here on."""
        connection = super().get_new_connection(conn_params)
        connection.__class__ = PatientConnection
        connection.wait_s = self._wait_s
        return connection
