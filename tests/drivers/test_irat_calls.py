"""Calls of the iRat's services as rosbridge's protocol allows them: any arguments, any id; each has its answer."""

import json

import pytest

from tests.conftest import wait_for
from tests.drivers.irat_wire import EPOCHS, WireClient, journal

pytestmark = pytest.mark.timed

IDS = ["7", 7, 1.5, True, 10**30, [1, {"a": None}], {"a": [2]}, "x" * 5000]


@pytest.mark.parametrize("args", [[], None, 5, "now", {}, [1, 2], {"a": {"b": []}}, False])
def test_a_hold_holds_whatever_its_arguments_are(irat, wire_client, args):
    wire_client.claim()
    with wire_client.driving(linear=0.1):
        wait_for(lambda: irat.status()["moving"], 5, "the motion")
        other = WireClient(irat)
        other.say("call_service", id="stop", service="/irat/hold", args=args, type=3, throttle_rate="x")
        answer = other.hear(lambda frame: frame.get("id") == "stop")
    assert answer["values"]["success"]
    wait_for(lambda: any(record["end"] == "held" for record in journal(irat, "rest")), 5, "the rest that it made")


@pytest.mark.parametrize("extra", [{"compression": "png"}, {"fragment_size": 100}, {"png": "png"}])
def test_a_hold_holds_whatever_form_of_answer_is_asked_for(irat, wire_client, extra):
    wire_client.say("call_service", id=5, service="irat/hold", **extra)
    assert "is not spoken here" in wire_client.complaint()
    answer = wire_client.hear(lambda frame: frame.get("id") == 5 and frame["op"] == "service_response")
    assert answer["values"]["success"]
    assert irat.count("hold") == 1


@pytest.mark.parametrize("ident", IDS, ids=lambda ident: str(ident)[:20])
def test_an_answer_has_the_id_of_its_call_in_its_own_type(wire_client, ident):
    for service in ("/irat/hold", "/irat/status", "/irat/dance"):
        wire_client.say("call_service", id=ident, service=service)
        answer = wire_client.hear(lambda frame: frame["op"] == "service_response")
        assert (answer["id"], type(answer["id"])) == (ident, type(ident))
        assert answer["service"] == service


@pytest.mark.parametrize(
    ("call", "why"),
    [
        ({}, "service must be a text"),
        ({"service": None}, "service must be a text"),
        ({"service": ["/irat/hold"]}, "service must be a text"),
        ({"service": "../x"}, "is not a name"),
        ({"service": "/irat/dance"}, "there is no service"),
        ({"service": "/irat/claim"}, "epoch"),
        ({"service": "/irat/claim", "args": []}, "epoch"),
        ({"service": "/irat/claim", "args": None}, "epoch"),
        ({"service": "/irat/claim", "args": {"epoch": 10**400}}, "epoch is an integer of 401 digits"),
    ],
)
def test_each_refused_call_is_answered_with_its_id(irat, wire_client, call, why):
    wire_client.say("call_service", id=17, **call)
    answer = wire_client.hear(lambda frame: frame.get("id") == 17)
    assert (answer["op"], answer["result"]) == ("service_response", False)
    assert why in answer["values"]
    assert irat.count("crash") == 0


def test_arguments_may_be_a_list_in_the_order_of_the_request(wire_client):
    epoch = next(EPOCHS)
    wire_client.say("call_service", id=1, service="/irat/claim", args=[epoch])
    assert wire_client.hear(lambda frame: frame.get("id") == 1)["values"]["epoch"] == epoch


@pytest.mark.parametrize("op", ["fragment", "png", "advertise_service", "auth"])
def test_what_is_not_spoken_is_said_with_the_id(wire_client, op):
    wire_client.say(op, id=3, data="x", num=0, total=2)
    said = wire_client.hear(lambda frame: frame["op"] == "status")
    assert said["id"] == 3
    assert "is not spoken here" in said["msg"]


def test_fragments_that_a_subscriber_asks_for_are_not_there_and_it_is_told(wire_client):
    wire_client.say("subscribe", id=9, topic="/irat/odom", fragment_size=200)
    said = wire_client.hear(lambda frame: frame["op"] == "status")
    assert (said["id"], said["level"]) == (9, "warning")
    assert "fragments" in said["msg"]
    wire_client.hear(lambda frame: frame.get("topic") == "/irat/odom")


def test_the_list_of_services_has_every_service_that_answers(wire_client):
    listed = wire_client.call("/rosapi/services")["values"]["services"]
    assert {"/irat/hold", "/irat/claim", "/irat/status", "/rosapi/topics", "/rosapi/services"} <= set(listed)
    for service in listed:
        assert "there is no service" not in json.dumps(wire_client.call(service))
    assert all(service in wire_client.call("/irat/dance")["values"] for service in listed)
