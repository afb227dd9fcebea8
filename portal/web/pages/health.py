"""`/livez`: this process answers. `/readyz`: database and Redis answer too."""

from django.db import DatabaseError, connection
from django.http import HttpRequest, HttpResponse, JsonResponse

from robots import bus


def livez(request: HttpRequest) -> HttpResponse:
    """Answer without using a store."""
    return HttpResponse("ok\n", content_type="text/plain; charset=utf-8")


def readyz(request: HttpRequest) -> HttpResponse:
    """Return whether database and Redis answer."""
    try:
        with connection.cursor() as cursor:
            cursor.execute("SELECT 1")
        database = True
    except DatabaseError:
        database = False
    redis = bus.alive()
    return JsonResponse({"database": database, "redis": redis}, status=200 if database else 503)
