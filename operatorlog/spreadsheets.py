"""CSV files that spreadsheets open with their umlauts, and in which they run nothing."""

import codecs
import csv
from collections.abc import Iterable, Sequence

from django.http import HttpResponse

# characters that start a formula in some spreadsheet
RUN = (
    "=",
    "+",
    "-",
    "@",
    "\t",
    "\r",
    "\n",
    "＝",
    "＋",
    "－",
    "＠",
)


def cell(text: str) -> str:
    """Return the text as a cell that no spreadsheet executes: a quote is put before the start of a formula."""
    return f"'{text}" if text.startswith(RUN) or text.lstrip().startswith(RUN) else text


def csv_response(name: str, rows: Iterable[Sequence[object]]) -> HttpResponse:
    """Return the rows as a download; the byte order mark tells Excel that it is UTF-8."""
    response = HttpResponse(codecs.BOM_UTF8, content_type="text/csv; charset=utf-8")
    response["Content-Disposition"] = f'attachment; filename="{name}.csv"'
    writer = csv.writer(response)
    writer.writerows([cell(str(value)) for value in row] for row in rows)
    return response
