"""The pictures of the orientations: they show the controls that the text names, with the text's numbers."""

import io
import re
from itertools import product

import pytest
from PIL import Image

from accounts.orientation import render, shapes
from portal.keep.seeding import SHIPPED
from robots.kit import description
from robots.models import Robot

pytestmark = pytest.mark.django_db


@pytest.fixture(params=product(SHIPPED, ("en", "de")), ids="-".join)
def shown(request, db):
    """A robot, and what its orientation names and shows."""
    driver, language = request.param
    request.getfixturevalue("client").cookies["django_language"] = language
    robot, _ = Robot.objects.get_or_create(
        driver=driver, defaults={"slug": driver, "name": driver, "address": f"sim:{driver}", "enabled": True}
    )
    controls = render(description.text_of(driver, "orientation.md")).controls
    return robot, controls, shapes(driver, controls, language)


def test_each_control_that_the_text_names_is_on_the_robots_page_and_in_the_picture(shown, client):
    robot, controls, found = shown
    assert len(controls) >= 4
    wide, narrow = found
    assert [place.number for place in wide.places] == list(range(1, len(controls) + 1))
    assert len(narrow.places) >= 3
    html = client.get(robot.get_absolute_url()).content.decode()
    for control in controls:
        assert f'id="{control}"' in html or f'data-command="{control}"' in html, "take the pictures again: make shots"


def test_the_places_lie_in_the_pictures_which_are_as_large_as_is_said(shown, client):
    robot, _, found = shown
    for shape, scheme in product(found, ("light", "dark")):
        answer = client.get(f"{robot.get_absolute_url()}orientation/{shape.look}-{scheme}.webp")
        assert answer["Content-Type"] == "image/webp"
        assert Image.open(io.BytesIO(answer.content)).size == (shape.width, shape.height)
        for place in shape.places:
            assert place.x >= 0
            assert place.y >= 0
            assert place.x + place.width <= shape.width
            assert place.y + place.height <= shape.height


def test_the_page_has_the_same_numbers_in_picture_and_text(shown, client):
    robot, controls, _ = shown
    html = client.get(f"{robot.get_absolute_url()}orientation/").content.decode()
    numbers = {str(number) for number in range(1, len(controls) + 1)}
    assert set(re.findall(r'class="control" data-number="(\d+)"', html)) == numbers
    wide = re.search(r'<figure class="tour-wide">.*?</figure>', html, re.DOTALL)[0]
    assert set(re.findall(r'<g data-number="(\d+)"', wide)) == numbers


@pytest.mark.parametrize(
    "look", ["wide", "wide-light.webp", "places", "..", "narrow-sepia", "xx-wide-light", "de-wide", "..-wide-light"]
)
def test_only_pictures_are_served(robot, client, look):
    assert client.get(f"/robots/mercury/orientation/{look}.webp").status_code == 404


def test_a_robot_without_pictures_has_its_text_alone(robot, client, installed):
    Robot.objects.filter(pk=robot.pk).update(driver="turntable")
    html = client.get("/robots/mercury/orientation/").content.decode()
    assert "<figure" not in html
    assert '<article class="prose">' in html
    assert client.get("/robots/mercury/orientation/wide-light.webp").status_code == 404
