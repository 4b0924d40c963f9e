"""The page's server: on this machine only, strict about what it is asked, in real time."""

import http.client
import json
import socket
import time

import pytest

from gapscope.analysis.errors import InputError
from gapscope.analysis.rig.server import serve


@pytest.fixture
def served(bench):
    server = serve(bench("slider").rig, 0)
    yield server
    server.shutdown()
    server.server_close()


def ask(server, method, path, body=None, **headers):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=20)
    try:
        connection.request(method, path, body, {"Content-Type": "application/json", **headers})
        answer = connection.getresponse()
        return answer.status, answer.read().decode()
    finally:
        connection.close()


def event(server, name, **data):
    status, text = ask(server, "POST", "/request", json.dumps({"event": name, "data": data}))
    return status, json.loads(text)


def test_page_layout_status_and_a_motion(served):
    assert "Virtual rig" in ask(served, "GET", "/")[1]
    layout = json.loads(ask(served, "GET", "/layout")[1])
    assert layout["kind"] == "slider"
    assert layout["transitions"]["stop"]["reset"] == "initialise"
    assert event(served, "jog")[1]["state"] == "jog"
    assert event(served, "start", axis="axis", speed=0.2)[1]["state"] == "jogging"
    assert event(served, "quick_stop")[1]["state"] == "stop"
    status = json.loads(ask(served, "GET", "/status")[1])
    assert sorted(status["allowed"]) == ["quick_stop", "reset", "shut_down"]  # nothing that moves


def test_it_keeps_the_time(served):
    """Samples follow the wall clock; how late a burst is depends on who else is on the machine, and is told."""
    first = served.status()["time_s"], time.perf_counter()
    time.sleep(1.0)
    second = served.status()["time_s"], time.perf_counter()
    if served.status()["resets"]:
        pytest.skip("the machine is too busy for real time")
    elapsed = second[1] - first[1]
    late = 1e-3 * served.status()["late_ms"]
    assert second[0] - first[0] == pytest.approx(elapsed, abs=late + 0.03)


@pytest.mark.parametrize(
    ("method", "path", "body", "headers", "status"),
    [
        ("GET", "/etc/passwd", None, {}, 404),
        ("GET", "/../errors.py", None, {}, 404),
        ("GET", "/status", None, {"Host": "evil.example:80"}, 403),
        ("POST", "/request", '{"event": "jog"}', {"Host": "evil.example"}, 403),
        ("POST", "/request", '{"event": "jog"}', {"Content-Type": "text/plain"}, 415),
        ("POST", "/request", "not json", {}, 400),
        ("POST", "/request", "[1]", {}, 400),
        ("POST", "/request", '{"event": "fly"}', {}, 400),
        ("POST", "/request", '{"event": "done"}', {}, 400),  # the machine's, not the user's
        ("POST", "/request", '{"event": "jog", "data": 3}', {}, 400),
        ("POST", "/request", '{"event": "start"}', {}, 409),
        ("POST", "/elsewhere", "{}", {}, 404),
        ("PUT", "/request", "{}", {}, 501),
    ],
)
def test_what_is_refused_changes_nothing(served, method, path, body, headers, status):
    before = served.rig.state
    found, text = ask(served, method, path, body, **headers)
    assert found == status, text
    assert "Traceback" not in text
    assert served.rig.state in (before, "operate")


def test_only_this_machine_can_connect(served):
    assert served.server_address[0] == "127.0.0.1"


def test_a_taken_port_is_one_message(bench):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(InputError, match="a free port"):
            serve(bench("slider").rig, taken.getsockname()[1])
