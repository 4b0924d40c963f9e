"""The rig's web page: a small server on this machine only.

It answers on 127.0.0.1, to requests that name this host (a page of another site cannot reach it by a name that points
here) and that are sent as JSON (another site's form cannot drive the machine).
"""

import json
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any

from ..errors import InputError
from .controller import Rig
from .pacing import Pacer
from .states import REQUESTS, TRANSITIONS, Event, Refused

HOST = "127.0.0.1"
LARGEST = 32 * 2**20  # of a request [bytes]: a table of some minutes


class RigServer(ThreadingHTTPServer):
    """Serves one rig; ``port`` 0 takes a free one."""

    daemon_threads = True

    def __init__(self, rig: Rig, port: int) -> None:
        self.rig, self.lock = rig, threading.Lock()
        self.pacer = Pacer(rig, self.lock)
        super().__init__((HOST, port), _Handler)
        self.page = files(__package__).joinpath("page.html").read_text(encoding="utf-8")

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self.server_port}/"

    def status(self) -> dict[str, Any]:
        """The rig's status and how well it keeps time."""
        with self.lock:
            found = self.rig.status()
        return found | {"late_ms": round(1e3 * self.pacer.late, 1), "resets": self.pacer.resets}

    def layout(self) -> dict[str, Any]:
        """What does not change: axes, motors, programs and the state machine."""
        layout = self.rig.machine.layout
        return {
            "kind": layout.kind,
            "axes": [
                {
                    "name": axis.name,
                    "unit": axis.unit,
                    "low": axis.low if axis.switched else None,
                    "high": axis.high if axis.switched else None,
                }
                for axis in layout.axes
            ],
            "motors": list(layout.motors),
            "effort": layout.effort,
            "rate": layout.rate,
            "tables": layout.tables,
            "programs": list(self.rig.machine.programs),
            "transitions": {
                str(s): {str(e): str(t) for e, t in row.items()} for s, row in TRANSITIONS.items()
            },
        }


class _Handler(BaseHTTPRequestHandler):
    server: RigServer
    protocol_version = "HTTP/1.1"
    timeout = 30

    def do_GET(self) -> None:
        """The page, its layout, the status, and the answer of the exercise."""
        routes = {
            "/layout": self.server.layout,
            "/status": self.server.status,
            "/answer": lambda: {"answer": self.server.rig.machine.answer},
        }
        if not self._from_here():
            return
        if self.path == "/":
            self._send(HTTPStatus.OK, self.server.page.encode(), "text/html; charset=utf-8")
        elif self.path in routes:
            self._json(HTTPStatus.OK, routes[self.path]())
        else:
            self._refuse(HTTPStatus.NOT_FOUND, f"no {self.path}")

    def do_POST(self) -> None:
        """``/request``: {"event": ..., "data": {...}}."""
        length = self.headers.get("Content-Length", "")
        if not length.isdigit() or int(length) > LARGEST:
            self.close_connection = True
            self._refuse(
                HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"at most {LARGEST} bytes, with their number"
            )
            return
        body = self.rfile.read(int(length))
        if not self._from_here():
            return
        if self.path != "/request":
            self._refuse(HTTPStatus.NOT_FOUND, f"no {self.path}")
        elif self.headers.get_content_type() != "application/json":
            self._refuse(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "expected application/json")
        else:
            self._request(body)

    def _request(self, body: bytes) -> None:
        try:
            content = json.loads(body)
            event, data = Event(content["event"]), content.get("data") or {}
            if event not in REQUESTS or not isinstance(data, dict):
                raise ValueError
        except (ValueError, KeyError, TypeError, AttributeError):
            names = ", ".join(REQUESTS)
            self._refuse(HTTPStatus.BAD_REQUEST, f"expected {{event, data}}, event one of {names}")
            return
        try:
            with self.server.lock:
                self.server.rig.request(event, data)
        except (Refused, InputError) as error:
            self._refuse(HTTPStatus.CONFLICT, str(error))
            return
        self._json(HTTPStatus.OK, self.server.status())

    def _from_here(self) -> bool:
        host = self.headers.get("Host", "").rpartition(":")[0]
        if host in (HOST, "localhost"):
            return True
        self._refuse(HTTPStatus.FORBIDDEN, f"ask for {self.server.url}")
        return False

    def _refuse(self, status: HTTPStatus, why: str) -> None:
        self._json(status, {"error": why})

    def _json(self, status: HTTPStatus, content: Any) -> None:
        self._send(status, json.dumps(content).encode(), "application/json")

    def _send(self, status: HTTPStatus, body: bytes, kind: str) -> None:
        self.send_response(status)
        for name, value in (
            ("Content-Type", kind),
            ("Content-Length", str(len(body))),
            ("Cache-Control", "no-store"),
            ("X-Content-Type-Options", "nosniff"),
            (
                "Content-Security-Policy",
                "default-src 'self' 'unsafe-inline'; frame-ancestors 'none'",
            ),
        ):
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *arguments: Any) -> None:
        """Silence: the page asks ten times a second."""


def serve(rig: Rig, port: int) -> RigServer:
    """A server whose rig runs; InputError if the port is taken."""
    try:
        server = RigServer(rig, port)
    except OSError as error:
        raise InputError(
            "--port", f"{port}: {error.strerror}", "a free port, or 0 for any"
        ) from None
    server.pacer.start()
    threading.Thread(target=server.serve_forever, name="server", daemon=True).start()
    return server
