"""Files of recordings that no row names are removed, whatever their own times are; a file that is written stays."""

import os
import threading
from datetime import UTC, datetime

import pytest
from django.db import connection

from robots.kit.clock import SYSTEM
from robots.recordings import cleaning, keeping
from tests.services.test_recordings import of_turn

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("media")]


@pytest.mark.parametrize("year", [1970, 2001, 2100])
def test_files_that_no_row_names_are_removed_whatever_their_own_times_are(roles, media, year):
    recording = of_turn()
    stray = keeping.path_of(recording).with_name("stray.tape")
    left = keeping.path_of(recording).with_name(f"{keeping.path_of(recording).stem}-0a1b2c3d{keeping.BUSY}")
    for path in (stray, left, keeping.path_of(recording)):
        path.touch()
        os.utime(path, (datetime(year, 2, 1, tzinfo=UTC).timestamp(),) * 2)
    assert cleaning.clean(SYSTEM.now()) == 2
    assert [path.name for path in stray.parent.iterdir()] == [keeping.path_of(recording).name]


@pytest.mark.skipif(not connection.features.has_select_for_update, reason="the database holds rows")
@pytest.mark.django_db(transaction=True)
def test_a_file_that_is_written_again_at_this_moment_is_left_alone_until_it_is_done(roles, media):
    recording = of_turn()
    new = keeping.path_of(recording).with_name(f"{keeping.path_of(recording).stem}-0a1b2c3d{keeping.BUSY}")
    held, over = threading.Event(), threading.Event()

    def write():
        with keeping.hold(recording):
            new.write_bytes(b"part")
            held.set()
            over.wait(60)
            new.replace(keeping.path_of(recording))
        connection.close()

    writer = threading.Thread(target=write)
    writer.start()
    assert held.wait(60)
    cleaner = threading.Thread(target=lambda: (cleaning.clean(SYSTEM.now()), connection.close()))
    cleaner.start()
    over.set()
    for thread in (writer, cleaner):
        thread.join(60)
    assert keeping.path_of(recording).read_bytes() == b"part"
