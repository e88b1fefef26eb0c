"""The page in the browser, at the level of HTTP; test_app_browser.py drives it in a browser."""

from __future__ import annotations

import contextlib
import csv
import http.client
import io
import json
import math
import os
import re
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
import urllib.parse
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import attrs
import numpy as np
import pytest
import roughcontact as rc
from roughcontact._solve.solution.plausibility import PLAUSIBILITY_RULES
from roughcontact.faces import TYPICAL, gather_warnings, list_quantities, write_column
from roughcontact.typing import Step, binary

from roughcontact_app import AppServer, Session, laws, materials, preview, scene, work
from roughcontact_app.answers import describe_solutions, describe_sweep, list_warnings, make_table, tabulate_path
from roughcontact_app.command import _shown
from roughcontact_app.connections import LIMIT
from roughcontact_app.outputs import make_law
from roughcontact_app.pool import Pool
from roughcontact_app.process import TaskEnded, Worker
from roughcontact_app.progress import Progress
from roughcontact_app.responses import ask_states
from roughcontact_app.scene import make_loads, make_problem, make_scene
from roughcontact_app.settings import DEFAULTS, FIRST, chosen_laws, list_values, load_values, quantity, read_settings
from roughcontact_app.uploads import shown_name
from roughcontact_app.words import in_words_of_page

PATIENCE = 120.0
SMALL = {"surface": "wavy", "cells": "48", "side": "50", "wavelength": "25", "boundary": "periodic"}
# Takes minutes: it is cancelled.
LONG = {"surface": "self-affine", "cells": "1536", "shortest": "0.4", "loads": " ".join(map(str, range(60, 100, 2)))}


# An array of objects, which numpy would read by pickle.
PICKLED = (
    b"\x93NUMPY\x01\x00v\x00{'descr': '|O', 'fortran_order': False, 'shape': (2, 2), }".ljust(128) + b"cos\nsystem\n."
)


class Client:
    def __init__(self, server):
        self.port, self.token, self.page = server.server_port, server.session.token, ""

    def request(self, method, path, body=None, headers=(), token=None):
        """Return status, headers and body; a POST has the origin of the page, unless it is given."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        sent = {"Origin": f"http://127.0.0.1:{self.port}"} if method == "POST" else {}
        sent |= {"X-Page": self.page, **dict(headers)}
        try:
            connection.request(
                method, f"/{self.token if token is None else token}/{path}", body, {k: v for k, v in sent.items() if v}
            )
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()
        finally:
            connection.close()

    def get(self, path):
        status, _, body = self.request("GET", path)
        assert status == 200, body
        return body

    def post(self, path, data, expected=200):
        status, headers, body = self.request("POST", path, json.dumps(data).encode())
        assert status == expected, body
        assert headers["Content-Type"] == "application/json"
        return json.loads(body)

    def refusal(self, path, data, expected=422):
        sentence = self.post(path, data, expected)["error"]
        assert sentence[0].isupper()
        assert sentence.endswith(".")
        assert "Traceback" not in sentence
        return sentence

    def upload(self, name, content, body=""):
        query = f"name={urllib.parse.quote(name)}&body={body}"
        status, _, body = self.request("POST", f"api/upload?{query}", content)
        return status, json.loads(body)

    def state(self, run):
        return json.loads(self.get(f"runs/{run}"))

    def wait(self, run, phases=("done", "failed", "cancelled")):
        end = time.monotonic() + PATIENCE
        while (state := self.state(run))["phase"] not in phases:
            assert time.monotonic() < end, state
            time.sleep(0.05)
        return state


def wait_until(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


@contextmanager
def serving(**options):
    session = Session(**options)
    try:
        with AppServer(session) as server:
            thread = threading.Thread(target=server.serve_forever, daemon=True)
            thread.start()
            yield server
            server.shutdown()
            thread.join()
    finally:
        session.close()


@pytest.fixture(scope="module")
def server():
    with serving(slots=1) as started:
        yield started


@pytest.fixture
def client(server):
    return Client(server)


@pytest.fixture(scope="module")
def solved(server):
    """A run of two loads that is done, and its client."""
    client = Client(server)
    run = client.post("api/runs", {**SMALL, "loads": "60 100"})["id"]
    state = client.wait(run)
    assert state["phase"] == "done", state
    return client, state


@pytest.fixture(scope="module")
def sweep():
    """The same by the library."""
    body = rc.Body(rc.WavySurface(0.5e-6, 25e-6), rc.Elastic(210e9, 0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((48, 48), 50e-6), boundary="periodic")
    return problem.sweep(pressure=[60e6, 100e6])


# Who may ask


@pytest.mark.parametrize("path", ["", "main.js", "api/start", "runs/0123456789abcdef01234567", "pictures/x"])
@pytest.mark.parametrize("token", ["", "x", "%00", "é", "TOKEN"])
def test_nothing_is_served_without_the_token(client, path, token):
    wrong = {"TOKEN": client.token[:-1] + chr(ord(client.token[-1]) ^ 1)}.get(token, urllib.parse.quote(token))
    status, _, body = client.request("GET", path, token=wrong)
    assert status == 403
    assert client.token.encode() not in body
    assert client.request("POST", path, b"{}", token=wrong)[0] == 403


def test_a_browser_is_refused_by_a_page_and_a_script_by_json(client):
    person = {"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"}
    for token, path, status in (("wrong", "", 403), (None, "<b>nothing</b>", 404)):
        found, headers, body = client.request("GET", urllib.parse.quote(path), headers=person, token=token)
        assert (found, headers["Content-Type"]) == (status, "text/html; charset=utf-8")
        assert body.startswith(b"<!doctype html>")
        assert b"<b>" not in body
        assert b"default-src 'none'" in headers["Content-Security-Policy"].encode()
        assert json.loads(client.request("GET", path and "nothing", token=token)[2])["error"].endswith(".")
    # The address without its last slash leads to the page.
    connection = http.client.HTTPConnection("127.0.0.1", client.port, timeout=PATIENCE)
    connection.request("GET", f"/{client.token}", headers=person)
    answer = connection.getresponse()
    assert (answer.status, answer.headers["Location"]) == (302, f"/{client.token}/")
    connection.close()


def test_the_token_cannot_be_guessed():
    with serving() as one, serving() as other:
        assert one.session.token != other.session.token
        assert len(one.session.token) >= 32


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:PORT", "127.0.0.1", "127.0.0.1:1", "[::1]:PORT", "x@127.0.0.1:PORT"]
)
def test_another_name_of_the_host_is_refused(client, host):
    status, _, body = client.request("GET", "", headers={"Host": host.replace("PORT", str(client.port))})
    assert status == 403
    assert b"127.0.0.1" in body


def test_localhost_is_a_name_of_the_host(client):
    assert client.request("GET", "", headers={"Host": f"localhost:{client.port}"})[0] == 200


@pytest.mark.parametrize(
    "origin", [None, "null", "http://evil.example", "https://127.0.0.1:PORT", "http://127.0.0.1:1"]
)
def test_only_its_own_page_may_send(client, origin):
    sent = {"Origin": origin and origin.replace("PORT", str(client.port))}
    for path in ("api/surface", "api/runs", "api/upload", "api/cancel/0"):
        assert client.request("POST", path, b"{}", headers=sent)[0] == 403


def test_it_listens_on_the_loopback_address_alone(server):
    assert server.server_address[0] == "127.0.0.1"


@pytest.mark.slow
def test_every_answer_has_the_headers_that_protect(client, solved):
    _, state = solved
    asked = [
        ("GET", ""),
        ("GET", "app.css"),
        ("GET", "nothing"),
        ("POST", "api/surface"),
        ("GET", f"runs/{state['id']}"),
    ]
    for method, path in asked:
        _, headers, _ = client.request(method, path, b"[]" if method == "POST" else None)
        policy = headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Referrer-Policy"] == "no-referrer"
        assert headers["Cache-Control"] == "no-store"
        assert not [name for name in headers if name.lower().startswith("access-control")]


def test_the_page_has_no_inline_script_and_needs_no_network(server):
    pages = server.pages
    assert {"index.html", "app.css", "main.js"} <= set(pages)
    html = pages["index.html"].decode()
    assert not re.search(r"<script(?![^>]*src=)|\son\w+=|style=", html)
    for name, content in pages.items():
        links = re.findall(r"https?://[^\s\"'`)]+", content.decode())
        assert [link for link in links if link != "http://www.w3.org/2000/svg"] == [], name
    for name in re.findall(r"(?:src|href)=\"([^\"]+)\"", html):
        assert name in pages
    for name in re.findall(r"from \"\./(.+)\"", "".join(pages[one].decode() for one in pages if one.endswith(".js"))):
        assert name in pages


def test_each_input_has_a_label(server):
    html = server.pages["index.html"].decode()
    for tag in re.findall(r"<(?:input|select)[^>]*>", html):
        name = re.search(r"\bid=\"(\w[\w-]*)\"", tag)
        assert "aria-label=" in tag or f'for="{name[1]}"' in html, tag


# What they may ask for


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [
        "../app.py", "..%2f..%2fserver.py", "%2e%2e/server.py", "static/main.js", "./main.js", "main.js%00.css",
        "/etc/passwd", "runs/RUN/../uploads", "runs/RUN/..%2f", "runs/RUN/solution-9.npz", "runs/RUN/.npz", "runs/../0",
        "pictures/../x",        "__init__.py", "index.html/", "C:\\Windows",
    ],
)  # fmt: skip
def test_no_path_leads_to_another_file(solved, path):
    client, state = solved
    status, _, body = client.request("GET", path.replace("RUN", state["id"]))
    assert status in (400, 403, 404)
    assert b"import" not in body
    assert b"root:" not in body


@pytest.mark.parametrize("method", ["PUT", "DELETE", "OPTIONS", "HEAD", "TRACE"])
def test_other_methods_are_not_served(client, method):
    assert client.request(method, "")[0] == 501


def talk(port, text, wait=10.0):
    with socket.create_connection(("127.0.0.1", port), timeout=wait) as connection:
        connection.sendall(text)
        found = b""
        while block := connection.recv(65536):
            found += block
    return found


def head(client, *lines, path="api/surface"):
    own = [
        f"POST /{client.token}/{path} HTTP/1.1",
        f"Host: 127.0.0.1:{client.port}",
        f"Origin: http://127.0.0.1:{client.port}",
    ]
    return "\r\n".join([*own, *lines, "", ""]).encode()


@pytest.mark.parametrize(
    "lines",
    [
        (),
        ("Content-Length: -1",),
        ("Content-Length: x",),
        ("Content-Length: 2", "Content-Length: 3"),
        ("Transfer-Encoding: chunked",),
        ("Content-Length: 2", "Transfer-Encoding: chunked"),
    ],
)
def test_a_request_states_its_length(client, lines):
    assert b" 411 " in talk(client.port, head(client, *lines)).splitlines()[0]


def test_too_long_a_body_is_refused_before_it_comes(client):
    assert b" 413 " in talk(client.port, head(client, "Content-Length: 100000"))
    answer = talk(client.port, head(client, "Content-Length: 999999999999", path="api/upload?name=a.csv"))
    assert b" 413 " in answer
    assert b"A file may have" in answer


@pytest.mark.parametrize(
    "text", [b"\x00\xff\xfe", b"GET / HTTP/9.9\r\n\r\n", b"GET\r\n\r\n", b"x" * 70000 + b"\r\n\r\n"]
)
def test_what_is_not_http_is_refused_and_the_server_lives(client, text):
    with pytest.raises(ConnectionError) if len(text) > 65536 else contextmanager(lambda: iter([0]))():
        assert b"Traceback" not in talk(client.port, text + b"\r\n")
        if len(text) > 65536:
            raise ConnectionError
    assert client.request("GET", "")[0] == 200


def test_a_slow_client_is_sent_away_and_holds_up_nobody(client, monkeypatch):
    monkeypatch.setattr("roughcontact_app.server._SILENCE", 0.2)
    answer = talk(client.port, head(client, "Content-Length: 20") + b"{")
    assert b" 408 " in answer.splitlines()[0]


def test_a_large_file_may_come_slowly(client, server, monkeypatch):
    monkeypatch.setattr("roughcontact_app.server._SILENCE", 1.0)
    monkeypatch.setitem(server.pages, "large.css", bytes(1 << 24))
    with connect(client) as connection:
        connection.sendall(f"GET /{client.token}/large.css HTTP/1.1\r\nHost: 127.0.0.1:{client.port}\r\n\r\n".encode())
        received = 0
        while block := connection.recv(1 << 18):
            received += len(block)
            time.sleep(0.03)
    assert received > 1 << 24


def test_a_client_that_does_not_read_is_sent_away(client, server, monkeypatch):
    monkeypatch.setattr("roughcontact_app.server._SILENCE", 0.3)
    monkeypatch.setitem(server.pages, "large.css", bytes(1 << 25))
    with connect(client) as connection:
        connection.sendall(f"GET /{client.token}/large.css HTTP/1.1\r\nHost: 127.0.0.1:{client.port}\r\n\r\n".encode())
        wait_until(lambda: server.connections._admitted)
        wait_until(lambda: not server.connections._admitted)
        received = 0
        with contextlib.suppress(ConnectionError):
            while block := connection.recv(1 << 20):
                received += len(block)
    assert received < 1 << 25


@pytest.mark.parametrize("path", ["", "api/start"])
def test_a_connection_has_one_request(client, path):
    one = f"GET /{client.token}/{path} HTTP/1.1\r\nHost: 127.0.0.1:{client.port}\r\n\r\n".encode()
    assert talk(client.port, one * 3).count(b"HTTP/1.1 ") == 1
    # Nor is it one of another kind.
    upgraded = one[:-2] + b"Connection: Upgrade\r\nUpgrade: websocket\r\nX-Forwarded-For: 1.2.3.4\r\n\r\n"
    assert talk(client.port, upgraded).startswith(b"HTTP/1.1 200 ")


def connect(client):
    return socket.create_connection(("127.0.0.1", client.port), timeout=PATIENCE)


def is_closed(connection):
    try:
        return connection.recv(1) == b""
    except ConnectionError:
        return True


def send_until_closed(connection):
    """Send a byte now and then; the patience of the test ends it too."""
    end = time.monotonic() + PATIENCE
    with contextlib.suppress(ConnectionError):
        while time.monotonic() < end:
            connection.sendall(b"x")
            time.sleep(0.02)
        pytest.fail("the connection is still open")


@pytest.mark.parametrize("first", [b"", b"GET /", b"GET / HTTP/1.1\r\nX-Page: "])
def test_connections_that_do_not_show_the_token_keep_nobody_out(client, server, first):
    with contextlib.ExitStack() as stack:
        silent = [stack.enter_context(connect(client)) for _ in range(3 * LIMIT)]
        for connection in silent[-LIMIT:]:
            connection.sendall(first)
        # The oldest make room for it, although none of those that are left has had its time.
        assert client.request("GET", "")[0] == 200
        assert is_closed(silent[0])
        assert len(server.connections._strangers) <= LIMIT
        silent[-1].setblocking(False)
        with pytest.raises(BlockingIOError):
            silent[-1].recv(1)


@pytest.mark.parametrize("text", ["GET /", "GET /TOKEN/ HTTP/1.1\r\nX-Page: ", "POST /wrong/ HTTP/1.1\r\n\r\n"])
def test_a_byte_now_and_then_buys_no_time_without_the_token(client, monkeypatch, text):
    monkeypatch.setattr("roughcontact_app.connections.PATIENCE", 0.3)
    with connect(client) as connection:
        connection.sendall(text.replace("TOKEN", client.token).encode())
        send_until_closed(connection)


def test_what_a_refused_client_goes_on_sending_is_not_read_for_ever(client, monkeypatch):
    monkeypatch.setattr("roughcontact_app.server._DRAINING", 0.3)
    with connect(client) as connection:
        connection.sendall(head(client, "Content-Length: 100000"))
        assert b" 413 " in connection.recv(4096)
        send_until_closed(connection)


def test_too_many_requests_at_once_are_refused_in_words(client, server, monkeypatch):
    monkeypatch.setattr("roughcontact_app.connections.LIMIT", 1)
    with connect(client) as busy:
        busy.sendall(head(client, "Content-Length: 20"))
        wait_until(lambda: server.connections._admitted)
        status, _, body = client.request("GET", "")
        assert (status, json.loads(body)["error"]) == (503, "There are too many requests at once: try it again.")
    wait_until(lambda: not server.connections._admitted)
    assert client.request("GET", "")[0] == 200


@pytest.mark.parametrize("body", [b"", b"{", b"\xff", b"[" * 60000, b'{"surface": NaN}', b"3", b"null", b"[]", b'"a"'])
def test_settings_that_are_not_json_are_refused_in_words(client, body):
    status, _, answer = client.request("POST", "api/surface", body)
    assert status in (400, 422)
    assert json.loads(answer)["error"].endswith(".")


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"young": "-1"}, "must be above 0, but got -1 GPa"),
        ({"young": ""}, "is missing"),
        ({"young": "nan"}, "must be a number such as 2.5"),
        ({"young": "1e99"}, "between"),
        ({"poisson": "0.7"}, "at most 0.5"),
        ({"hardness": "0"}, "The hardness"),
        ({"loads": "2,5"}, "with a point"),
        ({"loads": ""}, "is missing"),
        ({"loads": "1 1"}, "twice"),
        ({"loads": "1 -2"}, "above 0"),
        ({"loads": " ".join(map(str, range(1, 60)))}, "at most 40"),
        ({"load_unit": "N"}, "The unit of the pressure"),
        ({"load": "moment"}, "one of force"),
        ({"boundary": "open"}, "one of free"),
        ({"cells": "1e3"}, "a whole number such as 256"),
        ({"cells": "0"}, "at least"),
        ({"cells": "999999999"}, "of at most 2\\^40 cells"),
        ({"cells": "200000"}, "of memory, but"),
        ({"surface": "self-affine", "shortest": "0.001"}, "shortest wavelength"),
        ({"surface": "self-affine", "hurst": "2"}, "Hurst"),
        ({"surface": "example", "example": "__class__"}, "There is no example"),
        ({"surface": "file", "file": "../../etc/passwd"}, "Choose a file"),
        ({"ball": "-3"}, "radius"),
        ({"hardness": "1", "hardness_unit": "MPa", "loads": "100"}, "cannot be carried|can carry|hardness|limit"),
        ({"nothing": "1"}, "There is no setting"),
        ({"young": 210}, "a text"),
        ({"young": "1" * 400}, "a text"),
        ({"size_x": ["1"]}, "a text"),
    ],
)  # fmt: skip
def test_wrong_settings_are_refused_in_words(client, changed, words):
    assert re.search(words, client.refusal("api/runs", {**SMALL, **changed}))


# Maps


@pytest.mark.slow
def test_a_map_is_shown_and_solved_as_the_library_does(client, tmp_path):
    heights = rc.SelfAffineSurface(hurst=0.8, rms_height=0.2e-6, shortest=10e-6, longest=30e-6, seed=3).heights(
        rc.Grid((40, 36), (40e-6, 36e-6))
    )
    heights = heights + 0.01 * np.arange(40)[:, None] * 1e-6
    path = tmp_path / "my map.csv"
    np.savetxt(path, heights * 1e6, delimiter=",")
    status, found = client.upload("C:\\maps\\my map.csv", path.read_bytes())
    assert status == 200
    assert found["name"] == "my map.csv"
    assert found["facts"] == {"shape": [40, 36], "size": None, "metric": False, "needs_rows": True, "non_measured": 0}
    settings = {"surface": "file", "file": found["digest"], "file_name": found["name"], "form": "plane", "loads": "0.1"}
    settings |= {"load": "force", "load_unit": "N", "young": "70", "poisson": "0.33", "hardness": "2"}
    settings |= {"counterbody": "deformable", "counterbody_young": "3", "ball": "5"}
    assert "not the size of its domain: fill in both sides, x and y." in client.refusal("api/surface", settings)
    settings |= {"size_x": "40", "size_y": "36"}
    assert "does not state the unit of its heights: choose it." in client.refusal("api/surface", settings)
    settings |= {"height_unit": "um"}
    shown = client.post("api/surface", settings)
    surface = rc.read_surface(path, size=(40e-6, 36e-6), unit=1e-6).detrend("plane")
    assert shown["history"] == list(surface.history)
    rows = dict(shown["rows"])
    assert rows["Cells"] == "40 x 36"
    assert rows["Sq (rms height)"] == f"{surface.values.std() * 1e9:.4g} nm"
    state = client.wait(client.post("api/runs", settings)["id"])
    assert state["phase"] == "done", state
    problem = rc.ContactProblem(
        rc.Body(surface + rc.SphereSurface(5e-3), rc.ElasticPerfectlyPlastic(70e9, 0.33, 2e9)),
        rc.Body(rc.FlatSurface(), rc.Elastic(3e9, 0.3)),
    )
    solution = problem.solve(force=0.1)
    values = {one["name"]: (one["value"], one["uncertainty"]) for one in state["answers"][0]["quantities"]}
    area = solution.area()
    assert values["contact area"] == (area.value, area.uncertainty)
    assert values["maximum pressure"] == (solution.peak_pressure().value, solution.peak_pressure().uncertainty)
    assert values["saturated area"][0] == solution.saturated_area().value


def test_a_file_with_a_row_for_each_y_is_turned(client, exported_map):
    surface, by_x, by_y = exported_map
    settings = {"surface": "file", "non_measured": "keep", "size_x": "200", "size_y": "150", "height_unit": "um"}
    found = {path.stem: client.upload(path.name, path.read_bytes())[1] for path in (by_x, by_y)}
    assert found["x"]["facts"]["needs_rows"]
    refusal = client.refusal("api/surface", {**settings, "file": found["y"]["digest"]})
    assert (
        "a row for each y square ones of 500 nm. Say which it is: 'Rows of the file' y, or 'Rows of the file' x."
        in refusal
    )
    settings |= {"file": found["y"]["digest"], "rows": "y"}
    turned = client.post("api/surface", settings)
    rows = dict(turned["rows"])
    assert rows["Cells"] == "400 x 300"
    assert rows["Non-measured points"].startswith(f"{int(surface.non_measured.sum())} of")


@pytest.mark.slow
def test_a_file_with_a_row_for_each_y_is_solved(client, exported_map):
    surface, _, by_y = exported_map
    digest = client.upload(by_y.name, by_y.read_bytes())[1]["digest"]
    settings = {"surface": "file", "non_measured": "keep", "size_x": "200", "size_y": "150", "height_unit": "um"}
    settings |= {"loads": "200", "file": digest, "rows": "y"}
    state = client.wait(client.post("api/runs", settings)["id"])
    assert state["phase"] == "done", state
    area = next(one for one in state["answers"][0]["quantities"] if one["name"] == "contact area")
    problem = rc.ContactProblem(rc.Body(surface, rc.Elastic(210e9, 0.3)))
    assert area["value"] == pytest.approx(problem.solve(pressure=2e8).area().value, rel=1e-9)


def test_non_measured_points_are_asked_about(client):
    rough = 1e-6 * np.random.default_rng(1).random((20, 20))
    rough[3, 4:6] = np.nan
    file = io.BytesIO()
    np.savez(file, heights=rough, size=(20e-6, 20e-6))
    _, found = client.upload("map.npz", file.getvalue())
    assert found["facts"] == {
        "shape": [20, 20],
        "size": [20e-6, 20e-6],
        "metric": True,
        "needs_rows": False,
        "non_measured": 2,
    }
    settings = {"surface": "file", "file": found["digest"]}
    assert "2 points were not measured: choose whether" in client.refusal("api/surface", settings)
    kept = client.post("api/surface", {**settings, "non_measured": "keep"})
    assert dict(kept["rows"])["Non-measured points"] == "2 of 400"
    filled = client.post("api/surface", {**settings, "non_measured": "fill"})
    assert dict(filled["rows"])["Non-measured points"] == "2 of 400, filled"


def save_map(shape, size, seed):
    """Return a rough map, and the file that holds it."""
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=0.1e-6, shortest=8e-6, longest=24e-6, seed=seed)
    surface = rc.HeightMap(rough.heights(rc.Grid(shape, size)), size=size)
    file = io.BytesIO()
    np.savez(file, heights=surface.values, size=size)
    return surface, file.getvalue()


def test_the_roughness_of_a_map_is_that_of_the_library(client):
    surface, file = save_map((45, 64), (45e-6, 64e-6), 3)
    settings = {"surface": "file", "file": client.upload("map.npz", file)[1]["digest"], "form": "plane"}
    (shown,) = client.post("api/roughness", settings)["surfaces"]
    flat = surface.detrend("plane")
    expected = rc.reference.texture(flat.values, flat.grid, periodic=False)
    rows = {name: (meaning, text) for name, meaning, text in shown["rows"]}
    assert rows["Sq"] == ("root mean square height", write_column([expected.Sq])[0])
    assert rows["Smr1"] == ("material ratio of the peaks", write_column([expected.Smr1])[0])
    assert len(rows) == 22
    assert [one["panel"] for one in shown["pictures"]] == ["spectrum", "bearing-curve"]
    for one in shown["pictures"]:
        picture = client.get(f"pictures/{one['picture']}")
        assert picture.startswith(b"\x89PNG")
        # The page shows it 750 pixels wide.
        assert int.from_bytes(picture[16:20], "big") > 1000


@pytest.mark.parametrize("kind", ["sphere", "wavy"])
def test_surfaces_that_are_made_have_a_roughness_or_a_sentence(client, kind):
    (shown,) = client.post("api/roughness", {"surface": kind, "cells": "32"})["surfaces"]
    assert shown["rows"] or shown["notes"]
    assert client.refusal("api/roughness", {"surface": "file"})


PLACEMENT = {"offset_x": "4", "offset_y": "-2", "rotation": "20", "mirrored": "yes", "interpolation": "cubic"}


@pytest.fixture
def pair(client):
    """Two maps and the settings that press one on the other."""
    (body, first), (other, second) = save_map((64, 39), (64e-6, 39e-6), 1), save_map((90, 35), (60e-6, 50e-6), 2)
    digests = [client.upload(f"{name}.npz", file)[1]["digest"] for name, file in (("a", first), ("b", second))]
    settings = {"surface": "file", "file": digests[0], "counterbody_surface": "file", "counterbody_form": "plane"}
    return body, other.detrend("plane"), {**settings, "counterbody_file": digests[1], **PLACEMENT}


def test_two_maps_are_shown_and_solved_as_the_library_does(client, pair):
    body, other, settings = pair
    matched = rc.match(body, other, offset=(4e-6, -2e-6), rotation=np.deg2rad(20), mirrored=True, interpolation="cubic")
    shown = client.post("api/surface", settings)
    for one, surface in ((shown, matched.body), (shown["counterbody"], matched.counterbody)):
        assert dict(one["rows"])["Cells"] == " x ".join(map(str, matched.grid.shape))
        assert dict(one["rows"])["Sq (rms height)"] == f"{surface.heights(matched.grid).std() * 1e9:.4g} nm"
        assert client.get(f"pictures/{one['picture']}").startswith(b"\x89PNG")
    assert shown["picture"] != shown["counterbody"]["picture"]
    assert "turned over, x to -x" in shown["counterbody"]["history"]
    rough = client.post("api/roughness", settings)["surfaces"]
    assert [one["of"] for one in rough] == ["body", "counterbody"]
    for one, surface in zip(rough, (body, other), strict=True):
        expected = rc.reference.texture(surface.values, surface.grid, periodic=False)
        texts = {symbol: text for symbol, _, text in one["rows"]}
        assert texts["Sq"] == write_column([expected.Sq])[0]
    assert len({picture["picture"] for one in rough for picture in one["pictures"]}) == 4
    assert "b.npz" in client.post("api/plan", settings)["text"]
    ball = {"ball": "5", "load": "force", "load_unit": "N", "loads": "0.1", "counterbody": "deformable"}
    state = client.wait(client.post("api/runs", settings | ball)["id"])
    steel = rc.Elastic(210e9, 0.3)
    bodies = rc.Body(matched.body + rc.SphereSurface(5e-3), steel), rc.Body(matched.counterbody, steel)
    area = rc.ContactProblem(*bodies, grid=matched.grid).solve(force=0.1).area()
    values = {one["name"]: (one["value"], one["uncertainty"]) for one in state["answers"][0]["quantities"]}
    assert values["contact area"] == (area.value, area.uncertainty)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"counterbody_file": "0" * 64}, "the height map of the counterbody is not here."),
        (
            {"offset_x": "500"},
            "do not overlap where the second is shifted by (500 µm, -2 µm): move them together.",
        ),
        ({"offset_x": "1e30"}, "The shift along x must be between 1 fm and 1 km, but got 1e30 µm"),
        ({"rotation": "nan"}, "The rotation must be a number such as 2.5, but got 'nan'."),
        ({"rotation": "361"}, "The rotation must be between -360 and 360 degrees"),
        ({"mirrored": "perhaps"}, "The setting 'mirrored' must be one of no, yes"),
        ({"interpolation": "fourier"}, "The setting 'interpolation' must be one of bilinear, cubic"),
    ],
)
def test_maps_that_cannot_be_matched_are_refused_in_words(client, pair, changed, words):
    assert words in client.refusal("api/surface", pair[-1] | changed)


def test_a_second_map_that_the_page_does_not_show_is_not_solved(pair):
    settings = read_settings({**pair[-1], "surface": "wavy", "cells": "32"})
    assert make_scene(settings, None).counterbody is None


def test_a_tilt_is_warned_of_before_the_solve(client):
    tilted = io.BytesIO()
    np.savez(tilted, heights=np.add.outer(1e-7 * np.arange(40), 1e-7 * np.sin(np.arange(36))), size=(40e-6, 72e-6))
    _, found = client.upload("map.npz", tilted.getvalue())
    settings = {"surface": "file", "file": found["digest"]}
    shown = client.post("api/surface", settings)
    assert dict(shown["rows"])["Size of a cell"] == "1 µm x 2 µm"
    assert "is a tilt: unless it is meant, choose 'plane (tilt)' under 'Form that is removed'." in shown["warnings"][-1]
    for without in ({"form": "plane"}, {"ball": "5"}):
        assert not [text for text in client.post("api/surface", settings | without)["warnings"] if "tilt" in text]


def test_a_ball_that_the_page_does_not_show_is_not_added():
    settings = read_settings({"surface": "sphere", "radius": "1", "ball": "5"})
    scene = make_scene(settings, None)
    assert scene.surface is scene.body.surface


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.csv", b"1,2,3\n4,5\n"),
        ("a.csv", b"\xff\xfe\x00\x00"),
        ("a.csv", b"<script>alert(1)</script>"),
        ("a.npz", b"PK\x03\x04 nothing"),
        ("a.npy", PICKLED),
        ("a.x3p", b"PK\x03\x04 nothing"),
        ("a.plux", b"nothing"),
        ("a.exe", b"MZ"),
        ("", b"1"),
    ],
)  # fmt: skip
def test_a_file_that_is_not_a_map_is_refused_in_words(client, name, content):
    status, answer = client.upload(name, content)
    assert status == 422, answer
    sentence = answer["error"]
    assert sentence.endswith(".")
    assert "Traceback" not in sentence
    assert "roughcontact-app-" not in sentence
    # The server's name of the file is not shown.
    assert not re.search(r"[0-9a-f]{16}", sentence)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("map.png", b"\x89PNG\r\n\x1a\n" + b"\0" * 50, "map.png cannot be used: it is a PNG picture"),
        ("map.x3p", b"\x89PNG\r\n\x1a\n" + b"\0" * 50, "map.x3p cannot be used: it is a PNG picture"),
        ("photo.jpg", b"\xff\xd8\xff\xe0" + b"\0" * 50, "photo.jpg cannot be used: it is a JPEG picture"),
        ("zeros.x3p", b"\0" * 10000, "zeros.x3p cannot be used: it begins with 4096 bytes of zero"),
        ("zeros.csv", b"\0" * 10000, "zeros.csv cannot be used: it begins with 4096 bytes of zero"),
        ("words.x3p", b"1 2 3\n" * 9, "words.x3p cannot be used: it does not begin as .x3p files do"),
        ("a.SUR", b"nothing" * 9, "a.SUR cannot be used: it does not begin as .sur files do"),
    ],
)  # fmt: skip
def test_a_file_is_refused_by_its_first_bytes(client, name, content, said):
    status, answer = client.upload(name, content)
    assert status == 422
    assert said in answer["error"]
    assert "codec" not in answer["error"]


def test_an_empty_file_is_called_empty(client):
    status, answer = client.upload("a.csv", b"")
    assert (status, answer["error"]) == (413, "The file is empty: choose another, or export it again.")


def test_a_file_that_ends_early_is_refused(client):
    lines = head(client, "Content-Length: 50", path="api/upload?name=a.csv")
    with socket.create_connection(("127.0.0.1", client.port), timeout=30) as connection:
        connection.sendall(lines + b"1,2\n")
        connection.shutdown(socket.SHUT_WR)
        answer = b"".join(iter(lambda: connection.recv(65536), b""))
    assert b"ended 46 bytes before its stated length" in answer


def test_the_name_of_a_file_is_only_shown(client, server):
    _, found = client.upload("../../<b>evil</b>\n\0.csv", b"1 2\n3 4\n5 7\n")
    assert found["name"] == "b>.csv"
    stored = server.session.uploads.find(found["digest"])
    assert re.fullmatch(r"[0-9a-f]{16}\.csv", stored.path.name)
    assert shown_name("a" * 500 + ".csv").endswith("aaa.csv")
    assert len(shown_name("a" * 500 + ".csv")) == 100
    assert shown_name("///") == "map"


def test_uploads_lie_in_a_private_folder_that_ends_with_the_session():
    with serving() as server:
        Client(server).upload("a.csv", b"1,2\n3,4\n")
        folder = server.session.folder
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        assert len(list((folder / "uploads").iterdir())) == 1
    assert not folder.exists()


def test_the_oldest_uploads_give_way(client, server, monkeypatch):
    monkeypatch.setattr("roughcontact_app.uploads._LARGEST_SUM", 60)
    digests = [
        client.upload("a.csv", f"1 2\n3 {number}.000000000000000000000\n".encode())[1]["digest"] for number in range(3)
    ]
    assert [client.post("api/file", digest)["here"] for digest in digests] == [False, True, True]


def test_a_file_may_be_a_part_of_the_memory(client, monkeypatch):
    monkeypatch.setattr("roughcontact_app.uploads.available_memory", lambda: 40)
    status, answer = client.upload("a.csv", b"1,2\n3,4\n5,6\n")
    assert status == 413
    assert "at most 10 bytes" in answer["error"]


# A process of its own


def test_a_reader_that_takes_too_long_is_ended():
    with serving(patience=0.001) as server:
        client = Client(server)
        assert "Making the surface took more than 0.001 s" in client.refusal("api/surface", {})
        assert "Planning the solve took more than 0.001 s" in client.refusal("api/plan", {})
        status, answer = client.upload("ring.csv", b"1,2\n3,4\n")
        assert status == 422
        assert answer["error"].startswith("Reading the file ring.csv took more than 0.001 s and was ended: check")


def stop(worker):
    """Hold the process of a worker as a file that is slow to read does, and return it."""
    worker.start()
    os.kill(worker._process.pid, signal.SIGSTOP)
    return worker._process


def test_a_slow_file_holds_up_no_other_page_and_gives_way_to_the_next_of_its_own(client, server):
    slow, answers = Client(server), []
    slow.page = "slow"
    page = server.session._page("slow")
    process = stop(page._idle[0])
    reading = threading.Thread(target=lambda: answers.append(slow.upload("slow.csv", b"1 2\n3 5\n")))
    reading.start()
    end = time.monotonic() + PATIENCE
    while not page._reading:
        assert time.monotonic() < end
        time.sleep(0.01)
    status, found = client.upload("other.csv", b"1 2\n3 6\n")
    assert status == 200, found
    assert slow.post("api/plan", SMALL)["loads"]
    assert reading.is_alive()
    assert slow.upload("next.csv", b"1 2\n3 7\n")[0] == 200
    reading.join(PATIENCE)
    assert answers[0][0] == 422
    assert "Reading slow.csv was stopped, since another file was chosen." in answers[0][1]["error"]
    assert not process.is_alive()
    assert slow.upload("last.csv", b"1 2\n3 8\n")[0] == 200


def test_two_maps_are_read_at_once(server):
    """That of the counterbody does not end the reading of that of the body, nor the other way round."""
    both, answers = Client(server), {}
    both.page = "both"
    page = server.session._page("both")

    def read(body):
        answers[body] = both.upload(f"{body}map.csv", f"1 2\n3 {len(body)}\n".encode(), body)

    process = stop(page._idle[0])
    readings = [threading.Thread(target=read, args=(body,)) for body in ("", "counterbody_")]
    for count, reading in enumerate(readings, start=1):
        reading.start()
        end = time.monotonic() + PATIENCE
        while len(page._reading) < count and reading.is_alive():
            assert time.monotonic() < end
            time.sleep(0.01)
    readings[1].join(PATIENCE)
    assert answers["counterbody_"][0] == 200
    assert readings[0].is_alive()
    os.kill(process.pid, signal.SIGCONT)
    readings[0].join(PATIENCE)
    assert answers[""][0] == 200
    assert answers[""][1]["facts"]["shape"] == [2, 2]
    assert not page._reading
    # Two processes now wait for files; no name makes more.
    assert both.upload("third.csv", b"1 2\n3 9\n", "third_")[0] == 200
    assert len(page._idle) == 2


def test_reading_a_file_is_held_to_some_memory(server):
    page = server.session._page("held")
    worker = page._idle[0]
    task = server.session._task("inspect", read_settings({}), page.folder)
    assert worker.do(task | {"memory": 2**30}) == {}
    # Beside what is in use, some gigabytes may be reserved by threads: none is left beyond them.
    process = worker._process
    limit = Path(f"/proc/{process.pid}/limits").read_text()
    (line,) = (line for line in limit.splitlines() if line.startswith("Max address space"))
    used = int(Path(f"/proc/{process.pid}/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    assert int(line.split()[3]) < used + 4 * 2**30


def test_a_map_of_very_many_points_is_for_a_script(monkeypatch, tmp_path):
    monkeypatch.setattr(scene, "_MOST_POINTS", 11)
    np.savez(tmp_path / "a.npz", heights=np.eye(3, 4), size=(3e-6, 4e-6))
    with pytest.raises(rc.InputError, match=r"a\.npz has 3 x 4 points, but the page takes 11 at most"):
        scene.inspect_file(scene.Upload(tmp_path / "a.npz", "a.npz"))


def test_the_processes_of_many_pages_are_bounded():
    with serving() as server:
        first = server.session._page("0")
        for name in range(1, 5):
            assert server.session._page(str(name)) is not first
        assert server.session._page("0") is not first
        with pytest.raises(TaskEnded, match="cancelled"):
            first._maker.do({})


@pytest.mark.slow
def test_a_reader_that_crashes_takes_nothing_down(client, server):
    client.post("api/surface", SMALL)
    worker = server.session._page("")._maker
    process = worker._process
    process.kill()
    process.join()
    assert client.post("api/surface", {**SMALL, "amplitude": "0.7"})["rows"]
    assert worker._process is not process


def test_a_worker_that_dies_at_its_task_says_so():
    worker = Worker()
    try:
        worker.start()
        pipe = worker._started()
        os.kill(worker._process.pid, signal.SIGSTOP)
        threading.Timer(0.2, worker._process.kill).start()
        with pytest.raises(TaskEnded, match="ended before its time"):
            worker.do({})
        assert not pipe.closed
    finally:
        worker.close()
    with pytest.raises(TaskEnded, match="cancelled"):
        worker.do({})


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells the limits of another process")
def test_a_worker_may_take_no_more_memory_than_there_is():
    import resource

    worker = Worker()
    try:
        assert worker.do({"kind": "inspect", "upload": None, "settings": {}}) == {}
        before, after = (
            resource.getrlimit(resource.RLIMIT_AS),
            resource.prlimit(worker._process.pid, resource.RLIMIT_AS),
        )
        assert 0 < after[0] < 2**62
        assert after[1] == before[1]
    finally:
        worker.close()


# Runs


@pytest.mark.slow
def test_the_answers_are_those_of_the_library(solved, sweep):
    _, state = solved
    assert state["notes"] == []
    found = describe_solutions(sweep.states)
    assert state["warnings"] == list_warnings(found)
    for answer, expected, solution in zip(state["answers"], found, sweep.states, strict=True):
        assert answer["quantities"] == expected["quantities"]
        assert answer["warnings"] == expected["warnings"]
        assert answer["certified"]
        values = {one["name"]: one["value"] for one in answer["quantities"]}
        assert values["contact area"] == solution.area().value
        assert values["force"] == solution.force


@pytest.mark.slow
def test_the_table_is_the_answers_with_units(solved, sweep):
    client, state = solved
    rows = list(csv.DictReader(io.StringIO(client.get(f"runs/{state['id']}/answers.csv").decode("utf-8-sig"))))
    columns = {
        "contact area, m2": sweep.area,
        "force, N": sweep.force,
        "uncertainty of maximum pressure, Pa": [one.peak_pressure().uncertainty for one in sweep.states],
    }
    for name, expected in columns.items():
        np.testing.assert_allclose([float(row[name]) for row in rows], expected, rtol=1e-8)
    assert rows[0]["status"].startswith("converged")


@pytest.mark.slow
def test_the_fields_are_those_of_the_library(solved, sweep, tmp_path):
    client, state = solved
    for index, solution in enumerate(sweep.states):
        path = tmp_path / f"{index}.npz"
        path.write_bytes(client.get(f"runs/{state['id']}/solution-{index + 1}.npz"))
        with np.load(path) as data:
            assert np.array_equal(data["pressure"], solution.pressure)
            assert np.array_equal(data["gap"], solution.gap)
        assert rc.ContactSolution.load(path).origin.load == solution.origin.load


@pytest.mark.slow
def test_the_report_opens_alone_and_runs_no_script(solved):
    client, state = solved
    status, headers, body = client.request("GET", f"runs/{state['id']}/report.html")
    assert status == 200
    assert "sandbox" in headers["Content-Security-Policy"]
    assert "script-src" not in headers["Content-Security-Policy"]
    assert b"<!doctype html>" in body.lower()
    assert not re.search(rb"src=[\"']?(?!data:)\w", body)


@pytest.mark.slow
def test_there_is_a_picture_of_each_panel(solved, sweep):
    client, state = solved
    pictures = {one["panel"]: one["file"] for one in state["outputs"] if one["role"] == "picture"}
    assert set(pictures) == {
        name
        for name in rc.panels
        if rc.panels[name].subject in ("sweep", "solution") and rc.panels[name].fits(sweep[0])
    }
    assert next(iter(pictures)) == "area-load"
    for file in pictures.values():
        assert client.get(f"runs/{state['id']}/{file}")[:4] == b"\x89PNG"


def test_pictures_are_as_dark_as_the_page(client):
    light, dark = (
        client.get("pictures/" + client.post("api/surface", {**SMALL, "scheme": scheme})["picture"])
        for scheme in ("light", "dark")
    )
    assert light[:4] == b"\x89PNG"
    assert light != dark


def test_responses_are_those_of_the_library_in_answers_table_and_report(client):
    asked = {
        "ask_stiffness": "yes",
        "ask_stress": "yes",
        "ask_first_yield": "yes",
        "ask_first_yield_yield_stress": "900",
    }
    state = client.wait(client.post("api/runs", {**SMALL, **asked, "ask_stability": "yes", "loads": "60 100"})["id"])
    assert state["phase"] == "done", state
    body = rc.Body(rc.WavySurface(0.5e-6, 25e-6), rc.Elastic(210e9, 0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((48, 48), 50e-6), boundary="periodic")
    # The load of first yield is searched to 1e-4, from the same states.
    solution = problem.sweep(pressure=[60e6, 100e6]).states[0]
    values = {one["name"]: (one["value"], one["uncertainty"], one["unit"]) for one in state["answers"][0]["quantities"]}
    expected = {
        "stiffness": solution.stiffness(),
        "stress von Mises": solution.stress().maximum,
        "first yield force": solution.response(rc.responses.create("first-yield", yield_stress=900e6)).force,
    }
    for name, one in expected.items():
        assert values[name] == (pytest.approx(one.value, rel=1e-6), pytest.approx(one.uncertainty, rel=1e-3), one.unit)
    # What has no answer does not take the others down.
    assert "Stability: Without adhesion each state is stable: there is no jump." in state["warnings"]
    table = client.get(f"runs/{state['id']}/answers.csv").decode("utf-8-sig")
    assert '"stiffness, N/m","uncertainty of stiffness, N/m"' in table
    pictures = {one["panel"]: one["file"] for one in state["outputs"] if one["role"] == "picture"}
    assert client.get(f"runs/{state['id']}/{pictures['stiffness-load']}")[:4] == b"\x89PNG"
    assert not any(panel.startswith("stability") for panel in pictures)
    report = client.get(f"runs/{state['id']}/report.html").decode()
    assert "What the contact does" in report
    assert "tiffness, MN/m" in report


def test_numbers_of_responses_are_drawn_over_positive_loads(sweep):
    stiffness = [rc.Estimate(value, 1.0, "N/m") for value in (6.0, 8.0)]
    absent = [rc.Estimate(np.inf, 0.0, "W/K"), rc.Estimate(8.0, 1.0, "W/K")]
    law = make_law(attrs.evolve(sweep, states=sweep.states[::-1]), {"stiffness": stiffness, "conductance": absent})
    assert list(law.columns) == ["stiffness"]
    assert law.pressures == pytest.approx([60e6, 100e6], rel=1e-9)
    assert list(law["stiffness"].values) == [8.0, 6.0]
    assert not make_law(attrs.evolve(sweep, states=sweep.states[:1]), {"stiffness": stiffness[:1]}).columns


def test_an_infinite_answer_is_sent_as_json_can():
    infinite = rc.Estimate(np.inf, 0.0, "W/K")
    body = rc.Body(rc.WavySurface(1e-9, 25e-6), rc.Elastic(1e9, 0.3))
    solution = rc.ContactProblem(body, grid=rc.Grid((16, 16), 50e-6), boundary="periodic").solve(pressure=1e8)
    (answer,) = describe_solutions([solution], {"conductance": [infinite]})
    json.dumps(answer, allow_nan=False)
    assert answer["quantities"][-1] == {
        "name": "conductance",
        "value": None,
        "uncertainty": 0.0,
        "unit": "W/K",
        "text": "inf W/K",
    }
    assert ",,0.0," in make_table([answer])


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"ask_leakage": "yes"}, "Viscosity (leakage) is missing: fill it in."),
        ({"ask_leakage": "yes", "ask_leakage_viscosity": "nan"}, "Viscosity (leakage) must be a number"),
        (
            {"ask_conductance": "yes", "ask_conductance_conductivity": "5 0"},
            "Conductance: The conductivity of the bodies",
        ),
        (
            {"ask_conductance": "yes", "ask_conductance_conductivity": "1 2 3"},
            "has 3 numbers: give one, or one for each",
        ),
        ({"ask_first_yield": "yes", "ask_first_yield_yield_stress": "0"}, "Yield stress (first yield) must be above 0"),
        ({"ask_stiffness": "maybe"}, "The setting 'ask_stiffness' must be one of no, yes"),
        ({"ask_gradient": "yes"}, "ask_gradient"),
    ],
)
def test_wrong_fields_of_responses_are_refused_in_words(client, asked, words):
    assert words in client.refusal("api/plan", SMALL | asked)


def test_the_plan_says_time_and_memory_before_the_run(client):
    plan = client.post("api/plan", {**SMALL, "loads": "50 100"})
    assert plan["loads"] == ["pressure 50 MPa", "pressure 100 MPa"]
    # However fast the machine is; runs before have corrected it.
    assert 0.0 < plan["seconds"] < 100
    assert "MiB" in plan["memory"] or "KiB" in plan["memory"]
    assert "estimated" in plan["basis"]
    settings = read_settings(SMALL)
    assert plan["text"].splitlines()[0] == make_problem(settings, make_scene(settings, None)).explain().splitlines()[0]
    # Four times the cells, about four times as long.
    larger = client.post("api/plan", {**SMALL, "loads": "50 100", "cells": "1024"})
    assert larger["seconds"] > 3 * plan["seconds"]


@pytest.mark.slow
def test_a_run_is_cancelled_and_another_waits_for_it(client, server):
    running = client.post("api/runs", LONG)["id"]
    waiting = client.post("api/runs", SMALL)["id"]
    dropped = client.post("api/runs", SMALL)["id"]
    client.wait(running, ("solving",))
    state = client.state(dropped)
    assert state["phase"] == "waiting"
    assert "1 running, one a core, and 1 before this one" in state["text"]
    assert client.post(f"api/cancel/{dropped}", {})["phase"] == "cancelled"
    process = server.session.jobs.find(running).worker._process
    assert client.post(f"api/cancel/{running}", {})["phase"] == "cancelled"
    process.join(PATIENCE)
    assert client.wait(waiting)["phase"] == "done"
    assert client.state(running)["phase"] == client.state(dropped)["phase"] == "cancelled"
    assert client.state(running)["answers"] == []


def test_runs_in_the_queue_are_bounded(client, monkeypatch):
    monkeypatch.setattr("roughcontact_app.jobs._WAITING", 1)
    runs = [client.post("api/runs", LONG)["id"]]
    try:
        client.wait(runs[0], ("preparing", "solving"))
        runs.append(client.post("api/runs", SMALL)["id"])
        assert "The queue is full" in client.refusal("api/runs", SMALL)
    finally:
        for run in reversed(runs):
            client.post(f"api/cancel/{run}", {})


def test_the_numbers_of_a_run_say_their_load(solved):
    client, state = solved
    (listed,) = [one for one in json.loads(client.get("api/runs"))["runs"] if one["id"] == state["id"]]
    assert listed["numbers"]["load"] == f"{state['answers'][1]['load']}, the last of 2"
    texts = {one["name"]: one["text"] for one in state["answers"][1]["quantities"]}
    assert listed["numbers"]["contact area"] == texts["contact area"]


def test_runs_are_numbered_and_listed(client):
    first, second = (client.post("api/runs", SMALL) for _ in range(2))
    listed = json.loads(client.get("api/runs"))["runs"]
    assert [one["id"] for one in listed[-2:]] == [first["id"], second["id"]]
    assert second["number"] == first["number"] + 1 == listed[-1]["number"]
    assert listed[-1]["settings"] == second["settings"]
    for run in (first, second):
        client.post(f"api/cancel/{run['id']}", {})


def test_a_run_that_is_not_known_is_said_so(client):
    status, _, body = client.request("GET", "runs/" + "0" * 24)
    assert status == 404
    assert "solve again" in json.loads(body)["error"]
    assert client.refusal("api/cancel/x", {}, 404)


def test_ended_runs_are_forgotten_with_their_files(client, server, monkeypatch):
    monkeypatch.setattr("roughcontact_app.jobs._KEPT", 1)
    first, second = (client.post("api/runs", SMALL)["id"] for _ in range(2))
    for run in (second, first):
        client.post(f"api/cancel/{run}", {})
    folder = server.session.jobs.find(second).folder
    third = client.post("api/runs", SMALL)["id"]
    assert not folder.exists()
    assert client.request("GET", f"runs/{first}")[0] == 404
    client.post(f"api/cancel/{third}", {})


# Processes that are used again, and files that are written when they are asked for


def run_of(client, settings):
    state = client.wait(client.post("api/runs", settings)["id"])
    assert state["phase"] == "done", state
    return state


def process_for_runs(server):
    """The process that the next run will have."""
    pool = server.session.jobs._pool
    wait_until(lambda: pool._idle and pool._idle[-1]._process)
    return pool._idle[-1]._process


def test_the_numbers_of_a_run_come_before_its_pictures(tmp_path):
    seen = []

    def send(event):
        seen.append((set(event), sorted(path.name for path in tmp_path.iterdir())))

    work.run({"kind": "solve", "upload": None, "settings": SMALL, "folder": str(tmp_path)}, send)
    ((_, files),) = [one for one in seen if "answers" in one[0]]
    assert files == []
    assert "outputs" in next(names for names, _ in seen if "answers" in names)
    assert seen[-1][0] == {"made"}
    # Then the first picture, which somebody looks at; the others when they are.
    assert sorted(path.name for path in tmp_path.iterdir()) == ["pressure.png", "run.pickle"]


def test_files_are_written_when_they_are_asked_for(client, server):
    state = client.post("api/runs", {**SMALL, "amplitude": "0.6"})
    while not state["outputs"]:
        assert state["phase"] not in ("failed", "cancelled"), state
        state = json.loads(client.get(f"runs/{state['id']}?after={state['version']}"))
    # Early: the first one may be half done, and the run still has its process.
    first, *others = (one["file"] for one in state["outputs"] if one["role"] == "picture")
    for file in (others[-1], first):
        assert client.get(f"runs/{state['id']}/{file}")[:4] == b"\x89PNG"
    folder = server.session.jobs.find(state["id"]).folder
    assert not {"report.html", "answers.csv", "solution-1.npz", others[0]} & {path.name for path in folder.iterdir()}
    at_once, answers = [threading.Thread(target=lambda: answers.append(client.get(f"runs/{state['id']}/report.html")))
                        for _ in range(3)], []  # fmt: skip
    for thread in at_once:
        thread.start()
    for thread in at_once:
        thread.join(PATIENCE)
    assert len(answers) == 3
    assert len(set(answers)) == 1


def test_a_process_that_had_another_run_gives_the_same_bits(client, server):
    first = run_of(client, SMALL)
    process = process_for_runs(server)
    run_of(client, {**SMALL, "surface": "self-affine", "shortest": "5", "loads": "50 80"})
    again = run_of(client, SMALL)
    assert process_for_runs(server) is process
    assert [one["quantities"] for one in first["answers"]] == [one["quantities"] for one in again["answers"]]
    # What was not asked for while the process had the first run comes from what that has saved.
    for name in ("patches.png", "answers.csv"):
        assert client.get(f"runs/{first['id']}/{name}") == client.get(f"runs/{again['id']}/{name}")
    fields = []
    for state in (first, again):
        with np.load(io.BytesIO(client.get(f"runs/{state['id']}/solution-1.npz"))) as data:
            fields.append(data["pressure"])
    assert np.array_equal(*fields)


def test_the_process_of_a_cancelled_run_is_gone(client, server):
    process = process_for_runs(server)
    run = client.post("api/runs", LONG)["id"]
    client.wait(run, ("preparing", "solving"))
    assert server.session.jobs.find(run).worker._process is process
    client.post(f"api/cancel/{run}", {})
    assert not process.is_alive()
    # Cancelled again while another run goes on, it ends nothing.
    other = client.post("api/runs", SMALL)["id"]
    client.post(f"api/cancel/{run}", {})
    assert client.wait(other)["phase"] == "done"
    assert process_for_runs(server) is not process


def test_a_process_that_died_is_replaced(client, server):
    process = process_for_runs(server)
    process.kill()
    process.join()
    state = run_of(client, SMALL)
    other = process_for_runs(server)
    assert other is not process
    # So is one that dies at its run, which says so.
    running = client.post("api/runs", LONG)["id"]
    client.wait(running, ("preparing", "solving"))
    other.kill()
    failed = client.wait(running)
    assert (failed["phase"], failed["outputs"]) == ("failed", [])
    assert "ended before its time" in failed["error"]
    assert client.get(f"runs/{state['id']}/gap.png")[:4] == b"\x89PNG"
    assert run_of(client, SMALL)["answers"][0]["quantities"] == state["answers"][0]["quantities"]


def test_a_process_that_has_grown_is_ended(client, server, monkeypatch):
    process = process_for_runs(server)
    monkeypatch.setattr("roughcontact_app.pool._MOST_MEMORY", 2**20)
    state = run_of(client, SMALL)
    process.join(PATIENCE)
    assert not process.is_alive()
    assert client.get(f"runs/{state['id']}/gap.png")[:4] == b"\x89PNG"


def test_the_processes_for_runs_are_bounded():
    pool = Pool(2, 1)
    try:
        with pool.lend("a") as first, pool.lend("b") as second:
            first.start()
            assert first is not second
            with pytest.raises(TaskEnded, match="All processes have much to do"), pool.lend("c", 0.01):
                pass
        # One is kept, that which was used last.
        assert pool._idle == [first]
        assert second.is_closed
        with pool.lend("a") as again:
            assert again is first
            pool.close()
        assert first.is_closed
        with pytest.raises(TaskEnded, match="cancelled"), pool.lend("a"):
            pass
    finally:
        pool.close()


def test_a_file_that_takes_too_long_is_given_up_and_made_later(client, server, monkeypatch):
    state = run_of(client, SMALL)
    monkeypatch.setattr(server.session.jobs, "_patience", 0.001)
    status, _, body = client.request("GET", f"runs/{state['id']}/report.html")
    assert status == 422
    assert json.loads(body)["error"].startswith("Writing report.html took more than 0.001 s and was ended")
    monkeypatch.undo()
    assert client.get(f"runs/{state['id']}/report.html")[:15].lower() == b"<!doctype html>"


def test_what_a_run_has_not_kept_is_said_so(client, server):
    state = run_of(client, SMALL)
    run_of(client, {**SMALL, "loads": "70"})
    (server.session.jobs.find(state["id"]).folder / "run.pickle").unlink()
    status, _, body = client.request("GET", f"runs/{state['id']}/profile.png")
    assert (status, json.loads(body)["error"]) == (422, "The fields of this run are not here any more: solve again.")


def test_a_page_waits_for_the_next_phase_of_a_run(client):
    run = client.post("api/runs", LONG)
    try:
        solving = client.wait(run["id"], ("solving",))
        # It learns in a moment how far the run has come, and at once when that ends.
        later = json.loads(client.get(f"runs/{run['id']}?after={solving['version']}"))
        assert (later["phase"], later["version"]) == ("solving", solving["version"])
        for unknown in ("", "x", "-1", "9" * 40, "999"):
            assert json.loads(client.get(f"runs/{run['id']}?after={unknown}"))["phase"] == "solving"
    finally:
        ended = client.post(f"api/cancel/{run['id']}", {})
    assert ended["version"] > solving["version"]
    assert json.loads(client.get(f"runs/{run['id']}?after={ended['version']}"))["phase"] == "cancelled"


def test_scenes_are_shared_and_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(work, "_WORTH_SHARING", 0.0)
    sources = work.Sources(scenes=str(tmp_path))
    all_settings = [read_settings({**SMALL, "amplitude": f"0.{number}"}) for number in range(1, 8)]
    for settings in all_settings:
        made = work._scene(settings, sources)
    assert len(list(tmp_path.iterdir())) == work._SHARED
    work._cached_scene.cache_clear()
    shared = work._scene(all_settings[-1], sources)
    assert shared is not made
    assert np.array_equal(shared.surface.heights(shared.grid), made.surface.heights(made.grid))


# Styluses


def test_the_tip_of_a_stylus_is_taken_away(client):
    grid = rc.Grid((48, 48), 48e-6)
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=0.3e-6, shortest=8e-6, longest=48e-6, seed=1)
    traced = rc.HeightMap(rough.heights(grid), grid.size).traced("10um")
    file = io.BytesIO()
    np.savez(file, heights=traced.values, size=grid.size)
    _, found = client.upload("traced.npz", file.getvalue())
    settings = {"surface": "file", "file": found["digest"], "form": "plane", "load": "pressure", "loads": "100"}
    tip = {"tip_radius": "10"}
    restored = traced.restored("10um")
    shown = client.post("api/surface", {**settings, **tip})
    assert ["Certain below the tip", f"{100 * restored.certain_fraction:.3g} % of the points"] in shown["rows"]
    assert "restored below a tip of radius 10 µm" in " ".join(shown["history"])
    assert not any("tip" in text for text in shown["warnings"])
    assert "Certain" not in str(client.post("api/surface", settings)["rows"])
    body = rc.Body(restored.detrend("plane"), rc.Elastic(210e9, 0.3))
    area = rc.ContactProblem(body).solve(pressure=100e6).area()
    state = client.wait(client.post("api/runs", {**settings, **tip})["id"])
    quantities = {one["name"]: one for one in state["answers"][0]["quantities"]}
    assert quantities["contact area"]["value"] == pytest.approx(area.value, rel=1e-9)
    touched = quantities["part of the contact that the tip touched"]["value"]
    assert touched == pytest.approx(area.certain_fraction)
    # A blunter tip cannot have traced this map.
    shown = client.post("api/surface", {**settings, "tip_radius": "40"})
    assert any("sharper than the tip" in text for text in shown["warnings"])
    for text in ("0", "-1", "x", "1e12"):
        assert client.post("api/surface", {**settings, "tip_radius": text}, 422)["setting"] == "tip_radius"
    other = {"counterbody_surface": "file", "counterbody_file": found["digest"]}
    shown = client.post("api/surface", {**settings, **other, "counterbody_tip_radius": "10"})
    assert "Certain" in str(shown["counterbody"]["rows"])
    assert "Certain" not in str(shown["rows"])


# Film laws

FILM = {"surface": "self-affine", "cells": "32", "shortest": "8", "longest": "50", "boundary": "periodic"}
FILM |= {"load": "film", "separations": "0.5..1 3"}


@pytest.mark.slow
def test_a_film_law_is_that_of_a_script(client, tmp_path):
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, shortest=8e-6, longest=50e-6, seed=1)
    body = rc.Body(rough, rc.Elastic(210e9, 0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 1e-4), boundary="periodic")
    law = rc.film_law(problem, [0.5, 0.75, 1.0, 3.0])
    plan = client.post("api/plan", FILM)
    assert (plan["solves"], plan["loads"][1]) == (4, "0.75 Sq")
    assert "4 separations, 0.5 to 3 Sq, 20 states with those of the quarters" in plan["text"]
    assert plan["seconds"] > 0
    run = client.post("api/runs", {**FILM, "film_units": "mm"})["id"]
    state = client.wait(run)
    assert state["phase"] == "done", state
    # A text may be of another thread's rounding.
    for row, answer in enumerate(state["answers"]):
        known = {one["name"]: one for one in answer["quantities"]}
        assert known["separation over Sq"]["value"] == law.separations[row]
        for name, column in law.columns.items():
            one = known[name.replace("_", " ")]
            size = np.abs(column.values).max()
            assert one["value"] == pytest.approx(column.values[row], rel=1e-9, abs=1e-12 * size)
            assert one["uncertainty"] == pytest.approx(column.uncertainties[row], rel=1e-6, abs=1e-12 * size)
            if column.sampling is not None:
                assert one["sampling"] == pytest.approx(column.sampling[row], rel=1e-6)
    assert state["warnings"] == [f"{text.rstrip('.')}." for text in law.warnings]
    law.to_csv(tmp_path / "film.csv")
    law.to_json(tmp_path / "film.json")
    law.to_comsol(tmp_path / "film-comsol.txt", units="mm")
    law.to_text(tmp_path / "phi-xx.txt", "phi_xx", units="mm")
    for path in tmp_path.iterdir():
        served, by_script = (
            re.findall(r"-?\d+\.\d+e[-+]\d+|-?\d+\.\d+", text)
            for text in (client.get(f"runs/{run}/{path.name}").decode(), path.read_text(encoding="utf-8"))
        )
        # Of 1 +- 1e-10 only the order is known.
        assert len(served) == len(by_script) > 0, path
        pairs = zip(map(float, served), map(float, by_script), strict=True)
        assert all(one == pytest.approx(other, rel=1e-6, abs=1e-9) for one, other in pairs), path
    assert client.get(f"runs/{run}/phi-s-xx.png").startswith(b"\x89PNG")
    report = client.get(f"runs/{run}/report.html").decode()
    assert report.count("<svg") + report.count("<img") == len(law.short_table().columns) - 1
    shown = law.short_table().to_cells()[1]
    assert all(cell in report for row in shown for cell in row)


def test_a_map_of_a_film_law_is_mirrored_at_its_borders(client):
    rough = rc.SelfAffineSurface(hurst=0.8, rms_height=1e-7, shortest=8e-6, longest=25e-6, seed=2)
    heights = rough.heights(rc.Grid((32, 24), (4e-5, 3e-5)))
    file = io.BytesIO()
    np.savez(file, heights=heights, size=(4e-5, 3e-5))
    _, found = client.upload("liner.npz", file.getvalue())
    settings = {"surface": "file", "file": found["digest"], "boundary": "periodic", "load": "film"}
    settings |= {"separations": "1 2", "sampling": "no"}
    for mirrored, surface in (
        ("yes", rc.HeightMap(heights, (4e-5, 3e-5)).mirror_borders()),
        ("no", rc.HeightMap(heights, (4e-5, 3e-5))),
    ):
        body = rc.Body(surface, rc.Elastic(210e9, 0.3))
        law = rc.film_law(rc.ContactProblem(body, boundary="periodic"), [1.0, 2.0], sampling=False)
        state = client.wait(client.post("api/runs", {**settings, "mirror_borders": mirrored})["id"])
        quantities = {one["name"]: one for one in state["answers"][0]["quantities"]}
        assert quantities["phi xx"]["value"] == pytest.approx(law["phi_xx"].values[0], rel=1e-9)
        assert "sampling" not in quantities["phi xx"]
    other = {"counterbody_surface": "file", "counterbody_file": found["digest"]}
    answer = client.post("api/plan", {**settings, **other}, 422)
    assert answer["setting"] == "mirror_borders"
    client.post("api/plan", {**settings, **other, "mirror_borders": "no"})
    state = client.wait(client.post("api/runs", {**settings, **other, "mirror_borders": "no"})["id"])
    assert any(text.startswith("The columns phi_s are omitted: ") for text in state["warnings"])
    assert not any("phi s" in one["name"] for one in state["answers"][0]["quantities"])


@pytest.mark.parametrize(
    ("changed", "setting"),
    [
        ({"separations": "1"}, "separations"),
        ({"separations": "0.5..4..5"}, "separations"),
        ({"separations": "4..1"}, "separations"),
        ({"separations": "1 1"}, "separations"),
        ({"separations": "0 1"}, "separations"),
        ({"separations": ""}, "separations"),
        ({"separations": "1..100"}, "separations"),
        ({"surface": "sphere"}, "surface"),
        ({"ball": "1"}, "ball"),
        ({"boundary": "free"}, "boundary"),
        ({"adhesion": "exponential"}, "adhesion"),
        ({"ask_stiffness": "yes"}, "ask_stiffness"),
    ],
)
def test_a_film_law_that_is_not_known_is_refused(client, changed, setting):
    answer = client.post("api/plan", {**FILM, **changed}, 422)
    assert answer["setting"] == setting
    assert answer["error"].endswith(".")


@pytest.mark.slow
def test_a_film_law_is_cancelled(client):
    run = client.post("api/runs", {**FILM, "cells": "512", "separations": "0.5..8"})["id"]
    client.wait(run, ("solving",))
    client.post(f"api/cancel/{run}", {})
    assert client.wait(run)["phase"] == "cancelled"


# Without a server


@pytest.mark.parametrize(
    ("text", "unit", "value"), [("12.5", "um", 12.5e-6), ("3", "nm", 3e-9), ("1e-3", "m", 1e-3), (".1", "mm", 0.1e-3)]
)
def test_quantities_are_those_of_a_script_to_the_last_bit(text, unit, value):
    settings = read_settings({"side": text, "side_unit": unit})
    assert quantity(settings, "side", "The side", "length") == value


@pytest.mark.parametrize(
    ("changed", "setting"),
    [
        ({"loads": "x"}, "loads"),
        ({"loads": "1e30"}, "loads"),
        ({"poisson": "0.6"}, "poisson"),
        ({"hardness": "-1"}, "hardness"),
        ({"cells": "1.5"}, "cells"),
        ({"amplitude": ""}, "amplitude"),
        ({"load": "cycle"}, "adhesion"),
        ({"load": "fretting", "friction": "0"}, "friction"),
        ({"load": "fretting", "tangential_force": "1"}, "tangential_force"),
        ({"ask_conductance": "yes", "ask_conductance_conductivity": "0"}, "ask_conductance_conductivity"),
        ({"ask_leakage": "yes"}, "ask_leakage_viscosity"),
    ],
)
def test_a_refusal_names_the_wrong_setting(client, changed, setting):
    assert client.post("api/plan", SMALL | changed, 422)["setting"] == setting


def test_loads_are_separated_by_blanks_or_semicolons():
    assert load_values(read_settings({"loads": " 1 2;  5 ; ", "load_unit": "MPa"})) == [1e6, 2e6, 5e6]


STICKY = {"surface": "sphere", "radius": "6", "radius_unit": "um", "side": "8", "cells": "32", "young": "5"}
STICKY |= {"young_unit": "MPa", "poisson": "0.5", "load": "force", "load_unit": "nN", "adhesion": "exponential"}


def test_surfaces_that_attract_each_other_are_those_of_a_script():
    settings = read_settings({**STICKY, "load_unit": "N", "loads": "0 -2e-8", "range": "200"})
    problem = make_problem(settings, make_scene(settings, None))
    law = problem.adhesion
    assert (type(law), law.work, law.range) == (rc.Exponential, 50e-3, 200e-9)
    loads = make_loads(settings, problem)
    assert [load.value for load in loads] == [0.0, -2e-8]
    assert problem.solve(**loads[0].arguments).status.success


def test_only_surfaces_that_attract_each_other_are_pulled():
    with pytest.raises(rc.InputError, match="must be above 0, but got -2 N"):
        load_values(read_settings({**STICKY, "load_unit": "N", "loads": "-2", "adhesion": "none"}))


def test_adhesion_is_solved_and_drawn(client):
    run = client.post("api/runs", {**STICKY, "load_unit": "N", "loads": "0", "range": "200"})["id"]
    state = client.wait(run)
    assert state["phase"] == "done", state
    drawn = {one["panel"] for one in state["outputs"] if one["role"] == "picture"}
    assert {"pressure", "gap", "tension"} <= drawn


COATED = {**STICKY, "layers": "2", "layer1_young": "50", "layer1_young_unit": "MPa", "layer1_thickness": "0.3"}
COATED |= {"layer2_young": "1", "layer2_young_unit": "MPa", "layer2_poisson": "0.4", "layer2_thickness": "200"}
COATED |= {"boundary": "periodic", "layer2_thickness_unit": "nm", "load_unit": "nN", "loads": "500", "range": "200"}


@pytest.fixture
def layered():
    """The plug-in with the layers, without which nothing of them can be tried."""
    return pytest.importorskip("roughcontact_layered")


def test_a_coated_ball_its_first_yield_and_pull_off(client, layered):
    asked = {"ask_first_yield": "yes", "ask_first_yield_yield_stress": "4", "ask_pull_off": "yes"}
    state = client.wait(client.post("api/runs", {**COATED, **asked, "layer1_yield_stress": "0.01"})["id"])
    assert state["phase"] == "done", state
    (answer,) = state["answers"]
    found = {one["name"]: one["value"] for one in answer["quantities"]}
    hard, soft = layered.Layer(50e6, 0.25, 0.3e-6, yield_stress=10e6), layered.Layer(1e6, 0.4, 0.2e-6)
    kernel = layered.LayeredKernel((hard, soft), rc.Elastic(5e6, 0.5))
    ball = rc.Body(rc.SphereSurface(6e-6), rc.Elastic(5e6, 0.5))
    grid = rc.Grid((32, 32), 8e-6)
    law = rc.Exponential(50e-3, 200e-9)
    problem = rc.ContactProblem(ball, grid=grid, boundary="periodic", kernel=kernel, adhesion=law)
    solution = problem.solve(force=500e-9)
    assert found["approach"] == pytest.approx(solution.approach, rel=1e-6)
    assert found["pull off"] == pytest.approx(problem.pull_off().value, rel=1e-6)
    assert found["first yield force"] > 0.0
    assert "2 layers on the body: 300 nm of 50 MPa" in client.post("api/plan", COATED)["text"]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_layers_lie_on_either_body_and_on_a_rigid_base(boundary, layered):
    layer = {"counterbody_layers": "1", "counterbody_layer1_young": "2", "counterbody_layer1_young_unit": "MPa"}
    settings = read_settings({**STICKY, **layer, "boundary": boundary, "adhesion": "none"})
    problem = make_problem(settings, make_scene(settings, None))
    pad = layered.Layer(2e6, 0.25, 2e-6)
    assert problem.plan.kernel == layered.LayeredKernel(pad, rc.Rigid(), carrier="counterbody")
    assert problem.counterbody.material == rc.Elastic(2e6, 0.25)
    settings = read_settings({**settings, "counterbody": "deformable"})
    problem = make_problem(settings, make_scene(settings, None))
    assert problem.plan.kernel == layered.LayeredKernel(pad, rc.Elastic(210e9, 0.3), carrier="counterbody")


@pytest.mark.parametrize(
    ("given", "setting", "sentence"),
    [
        ({"layer2_thickness": "-1"}, "layer2_thickness", "The thickness of layer 2 of the body must be above 0"),
        ({"layer1_young": ""}, "layer1_young", "Young's modulus of layer 1 of the body is missing: fill it in."),
        ({"layer1_poisson": "0.7"}, "layer1_poisson", "Poisson's ratio must be"),
        ({"layers": "4"}, "", "The setting 'layers' must be one of 0, 1, 2, 3, but got '4'."),
    ],
)
def test_wrong_layers_name_their_setting(client, layered, given, setting, sentence):
    refused = client.post("api/plan", {**COATED, **given}, 422)
    assert sentence in refused["error"]
    assert refused.get("setting", "") == setting


def test_without_the_plug_in_the_page_says_what_to_install(monkeypatch):
    from roughcontact._base.archive.plain import parts

    monkeypatch.setattr(parts, "_installed", {})
    monkeypatch.setattr(parts, "_classes", {})
    settings = read_settings(COATED)
    with pytest.raises(rc.InputError, match="pip install roughcontact-layered") as caught:
        make_problem(settings, make_scene(settings, None))
    assert caught.value.setting == "layers"


CYCLE = {**STICKY, "load_unit": "nN", "load": "cycle", "range": "30", "cells": "96", "side": "6"}
CYCLE |= {"cycle_from": "-0.3", "cycle_to": "0.1", "states": "9"}


def test_a_cycle_is_planned_solved_drawn_and_tabulated(client):
    plan = client.post("api/plan", CYCLE)
    assert (len(plan["loads"]), plan["solves"]) == (9, 17)
    state = client.wait(client.post("api/runs", CYCLE)["id"])
    assert state["phase"] == "done", state
    settings = read_settings(CYCLE)
    problem = make_problem(settings, make_scene(settings, None))
    expected = problem.cycle(approach=np.linspace(-0.3e-6, 0.1e-6, 9))
    (answer,) = state["answers"]
    found = {one["name"]: one for one in answer["quantities"]}
    # That of the problem: the states of the cycle are 50 nm apart, the range is 30 nm.
    assert found["pull-off"]["value"] == pytest.approx(problem.pull_off().value, rel=1e-6)
    assert found["pull-in"]["value"] == pytest.approx(expected.pull_in.value, rel=1e-6)
    assert found["energy lost"]["value"] == pytest.approx(expected.dissipated.value, rel=1e-3)
    assert found["jumps"]["value"] == len(expected.jumps) > 0
    assert found["jumps"]["text"].startswith(f"{len(expected.jumps)}: ")
    assert found["pull-off"]["text"].endswith("µN")
    assert not any(PYTHON.search(text) for text in state["warnings"])
    files = {one["role"]: one["file"] for one in state["outputs"]}
    assert client.get(f"runs/{state['id']}/{files['picture']}")[:4] == b"\x89PNG"
    table = client.get(f"runs/{state['id']}/{files['table']}").decode("utf-8")
    rows = list(csv.DictReader(io.StringIO(table)))
    assert [row["branch"] for row in rows] == ["loading"] * 9 + ["unloading"] * 9
    forces = np.concatenate([expected.loading.force, expected.unloading.force])
    np.testing.assert_allclose([float(row["force [N]"]) for row in rows], forces, atol=1e-6 * np.abs(forces).max())


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"adhesion": "none"}, "A cycle is for surfaces that attract each other: choose an adhesion, or give another"),
        ({"cycle_from": "0.3"}, "The first approach of a cycle must be below the last one"),
        ({"cycle_to": "1,5"}, "The last approach must be a number such as 2.5, but got '1,5'."),
        ({"cycle_unit": "lb"}, "The unit of the approach must be one of m, mm, um, nm, but got 'lb'."),
        ({"states": "1"}, "The number of states must be from 2 to 201, but got 1."),
        ({"states": "2.5"}, "The number of states must be a whole number such as 256, but got '2.5'."),
        ({"range": "1"}, "A path cannot be followed: the cohesive length"),
    ],
)
def test_a_cycle_that_cannot_be_followed_is_refused_before_it_is_solved(client, given, sentence):
    assert sentence in client.refusal("api/plan", {**CYCLE, **given})


FRETTING = {"surface": "sphere", "radius": "1", "radius_unit": "mm", "side": "100", "cells": "32", "load": "fretting"}
FRETTING |= {"counterbody": "deformable", "normal_force": "1", "tangential_force": "200", "tangential_force_unit": "mN"}


def test_the_responses_of_a_cycle_are_shown_and_tabulated(client):
    asked = {"ask_stiffness": "yes", "ask_conductance": "yes", "ask_conductance_conductivity": "50"}
    state = client.wait(client.post("api/runs", {**CYCLE, **asked})["id"])
    assert state["phase"] == "done", state
    settings = read_settings(CYCLE)
    cycle = make_problem(settings, make_scene(settings, None)).cycle(approach=np.linspace(-0.3e-6, 0.1e-6, 9))
    found = {one["name"]: one for one in state["answers"][0]["quantities"]}
    last = cycle.loading[-1]
    table = client.get(f"runs/{state['id']}/{state['outputs'][0]['file']}").decode("utf-8")
    rows = list(csv.DictReader(io.StringIO(table)))
    for name, unit, expected in (
        ("stiffness", "N/m", last.stiffness()), ("conductance", "W/K", last.conductance(50.0)),
    ):  # fmt: skip
        shown = found[f"{name} at the last approach"]
        assert shown["value"] == pytest.approx(expected.value, rel=1e-4)
        assert shown["uncertainty"] == pytest.approx(expected.uncertainty, rel=1e-2)
        # Unloading starts where loading ends.
        values = [float(row[f"{name} [{unit}]"]) for row in rows]
        assert values[8] == values[9] == pytest.approx(expected.value, rel=1e-4)
        assert len(values) == 18
    assert float(rows[12]["conductance [W/K]"]) == pytest.approx(cycle.unloading[3].conductance(50.0).value, rel=1e-4)
    report = client.get(f"runs/{state['id']}/report.html").decode()
    # Both branches, with the answers of each state.
    assert report.count('<th scope="row">loading</th>') == report.count('<th scope="row">unloading</th>') == 9
    assert "stiffness, " in report
    assert [one["role"] for one in state["outputs"]] == ["table", "picture", "report"]


def test_a_response_without_an_answer_leaves_the_others_of_a_cycle():
    settings = read_settings(CYCLE)
    cycle = make_problem(settings, make_scene(settings, None)).cycle(approach=np.linspace(-0.3e-6, 0.1e-6, 3))
    states = cycle.states

    class Picky(rc.Response):
        holds_with = frozenset({"tension", "shear"})

        def respond(self, solution):
            if solution is states[0]:
                raise rc.InputError("nothing touches")
            return rc.Estimate(1.0, 0.1, "m")

    found, problems = ask_states({"stiffness": Picky()}, states)
    assert problems == ["Stiffness: 1 of 5 states have no answer: nothing touches."]
    column = tabulate_path(cycle, found).columns["stiffness"]
    assert [one.value for one in column[1:]] == [1.0] * 5
    assert math.isnan(column[0].value)


def test_the_responses_of_a_fretting_cycle_are_shown_and_tabulated(client):
    asked = {"ask_stiffness": "yes", "ask_stress": "yes", "ask_conductance": "yes"}
    asked |= {"ask_conductance_conductivity": "50 W/(m K) 20W/m/K"}
    asked |= {"ask_first_yield": "yes", "ask_first_yield_yield_stress": "500"}
    state = client.wait(client.post("api/runs", {**FRETTING, **asked})["id"])
    assert state["phase"] == "done", state
    settings = read_settings(FRETTING)
    problem = make_problem(settings, make_scene(settings, None))
    path = problem.path(force=1.0, tangential_force=work.list_forces(problem, 0.2), friction=0.3)
    found = {one["name"]: one for one in state["answers"][0]["quantities"]}
    contact = path[-1]
    assert found["stiffness at the end"]["value"] == pytest.approx(contact.stiffness().value, rel=1e-6)
    assert found["conductance at the end"]["value"] == pytest.approx(contact.conductance((50.0, 20.0)).value, rel=1e-6)
    # Under pressure and traction.
    stress = path[-1].stress().maximum.value
    assert found["stress von Mises at the end"]["value"] == pytest.approx(stress, rel=1e-4)
    said = "First yield: no state has an answer: "
    assert any(text.startswith(said) for text in state["warnings"]), state["warnings"]
    assert "stiffness, MN/m" in client.get(f"runs/{state['id']}/report.html").decode()
    (table,) = (one["file"] for one in state["outputs"] if one["role"] == "table")
    rows = list(csv.DictReader(io.StringIO(client.get(f"runs/{state['id']}/{table}").decode("utf-8"))))
    assert [float(row["stiffness [N/m]"]) for row in rows] == pytest.approx([path[0].stiffness().value] * 20, rel=1e-4)


def test_a_fretting_cycle_is_planned_solved_drawn_and_tabulated(client, tmp_path):
    plan = client.post("api/plan", FRETTING)
    # To the first turn, back, and there again.
    assert (len(plan["loads"]), plan["solves"]) == (1, 4 + 8 + 8)
    state = client.wait(client.post("api/runs", FRETTING)["id"])
    assert state["phase"] == "done", state
    settings = read_settings(FRETTING)
    problem = make_problem(settings, make_scene(settings, None))
    expected = problem.path(force=1.0, tangential_force=work.list_forces(problem, 0.2), friction=0.3)
    (answer,) = state["answers"]
    assert answer["certified"]
    found = {one["name"]: one["value"] for one in answer["quantities"]}
    lost = sum(one.dissipated.value for one in expected.numbers[4:])
    assert found["energy lost in a cycle"] == pytest.approx(lost, rel=1e-6)
    # The states between the turns change nothing of the cycle.
    turns = problem.path(force=1.0, tangential_force=[(0.2, 0.0), (-0.2, 0.0), (0.2, 0.0)], friction=0.3)
    assert lost == pytest.approx(sum(one.dissipated.value for one in turns.numbers[1:]), rel=1e-3)
    ends = turns.loop.displacement[2:, 0]
    assert found["displacement from turn to turn"] == pytest.approx(ends[1] - ends[0], rel=1e-3)
    assert found["area that sticks at the first turn"] == turns.numbers[1].stick_area.value
    # The loop is open: there is another displacement at the same force on the way back.
    assert expected.loop.displacement[8, 0] > 0.05 * ends[1] > -0.05 * ends[1] > expected.loop.displacement[16, 0]
    files = {one["role"]: one["file"] for one in state["outputs"]}
    assert client.get(f"runs/{state['id']}/{files['picture']}")[:4] == b"\x89PNG"
    table = client.get(f"runs/{state['id']}/{files['table']}").decode("utf-8")
    forces = [float(row["tangential_x [N]"]) for row in csv.DictReader(io.StringIO(table))]
    assert forces == pytest.approx([force for force, _ in work.list_forces(problem, 0.2)], rel=1e-6, abs=1e-9)
    saved = tmp_path / "path.npz"
    saved.write_bytes(client.get(f"runs/{state['id']}/{files['path']}"))
    assert rc.FrictionalPath.load(saved).dissipated.value == pytest.approx(expected.dissipated.value, rel=1e-6)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"tangential_force": "300"}, "must be below the coefficient of friction times the normal force"),
        ({"friction": "0"}, "The coefficient of friction must be above 0, and at most 10, but got 0"),
        ({"friction": ""}, "The coefficient of friction is missing: fill it in."),
        ({"normal_force": "-1"}, "The normal force must be above 0, but got -1 N."),
        ({"tangential_force_unit": "lbf"}, "The unit of the force must be one of N, mN, uN, nN, kN, but got 'lbf'."),
        ({"boundary": "wrapped"}, "A wrapped boundary has no response to forces along the surface"),
        ({"adhesion": "short-range"}, "Friction between surfaces that attract each other is not known"),
    ],
)
def test_a_fretting_cycle_that_cannot_be_followed_is_refused_before_it_is_solved(client, given, sentence):
    assert sentence in client.refusal("api/plan", {**FRETTING, **given})


def test_friction_on_layers_is_refused_before_it_is_solved(client, layered):
    assert "Friction on layers is not known" in client.refusal("api/plan", {**FRETTING, "layers": "1"})


@pytest.mark.parametrize("counterbody", ["deformable", "rigid"])
def test_the_progress_of_a_fretting_cycle_only_grows(tmp_path, counterbody):
    sent = []
    task = {"kind": "solve", "upload": None, "settings": {**FRETTING, "counterbody": counterbody}}
    work.run({**task, "folder": str(tmp_path)}, sent.append)
    solving = [event for event in sent if event.get("phase") == "solving"]
    fractions = [event["fraction"] for event in solving]
    assert fractions == sorted(fractions)
    assert 0.0 == fractions[0] < fractions[-1] <= 1.0
    assert solving[1]["text"].startswith("pressing, increment 1 of 1")
    assert solving[-1]["text"].startswith(f"step {20 if counterbody == 'deformable' else 3} of ")
    # Of like materials the number of increments is known.
    assert counterbody == "rigid" or fractions[1:] == pytest.approx([step / 21 for step in range(1, 22)])


BALL = {"surface": "sphere", "radius": "1", "radius_unit": "mm", "side": "100", "cells": "32", "path": "yes"}
BALL |= {"load": "force", "load_unit": "N"}
YIELDS = {**BALL, "loads": "4 0 2 4", "hardness": "2", "hardness_unit": "GPa"}
WORN = {**BALL, "loads": "1", "sliding": "0 100mm 1", "law_archard": "yes", "law_archard_coefficient": "1e-10 mm2/N"}
RELAXES = {
    **BALL,
    "loads": "0.05",
    "side": "3",
    "side_unit": "mm",
    "radius": "10",
    "time": "0 10 1s",
    "time_unit": "ms",
}
RELAXES |= {
    "material": "viscoelastic",
    "moduli": "1 3MPa",
    "relaxation": "10",
    "relaxation_unit": "ms",
    "poisson": "0.5",
}


def follow(given):
    """Return the path of settings as a script follows it."""
    soft = rc.Viscoelastic(["1MPa", "3MPa"], ["10ms"], 0.5)
    scenes = {
        "4 0 2 4": (rc.ElasticPerfectlyPlastic(210e9, 0.3, 2e9), 1e-3, 100e-6, (), {"force": [4.0, 0.0, 2.0, 4.0]}),
        "1": (rc.Elastic(210e9, 0.3), 1e-3, 100e-6, rc.Archard(1e-16), {"force": 1.0, "sliding": [0.0, 0.1, 1.0]}),
        "0.05": (soft, 10e-3, 3e-3, (), {"force": 0.05, "time": [0.0, 0.01, 1.0]}),
    }
    material, radius, side, laws, loads = scenes[given["loads"]]
    ball = rc.Body(rc.SphereSurface(radius), material)
    return rc.ContactProblem(ball, grid=rc.Grid((32, 32), side), laws=laws).path(**loads)


@pytest.mark.parametrize(
    ("given", "column"),
    [(YIELDS, "plastic work"), (WORN, "worn volume"), (RELAXES, "time")],
    ids=["hard", "worn", "soft"],
)
def test_a_path_is_planned_solved_drawn_and_tabulated(client, tmp_path, given, column):
    expected = follow(given)
    plan = client.post("api/plan", given)
    assert plan["solves"] == len(expected)
    state = client.wait(client.post("api/runs", given)["id"])
    assert (state["phase"], state["notes"]) == ("done", []), state
    assert len(state["answers"]) == len(expected)
    values = [{one["name"]: one["value"] for one in answer["quantities"]} for answer in state["answers"]]
    table = expected.table().columns
    for name, numbers in (("approach", expected.approach), (column, table[column.replace(" ", "_")])):
        np.testing.assert_array_equal([one[name] for one in values], numbers)
    assert [one["contact area"] for one in values] == [one.area().value for one in expected]
    assert len(set(state["warnings"])) == len(state["warnings"])
    files = {one["role"]: one["file"] for one in state["outputs"] if one["role"] != "picture"}
    rows = list(csv.DictReader(io.StringIO(client.get(f"runs/{state['id']}/{files['table']}").decode("utf-8"))))
    assert [float(row["approach [m]"]) for row in rows] == expected.approach.tolist()
    assert client.get(f"runs/{state['id']}/{files['animation']}")[:6] == b"GIF89a"
    saved = tmp_path / "path.npz"
    saved.write_bytes(client.get(f"runs/{state['id']}/{files['path']}"))
    assert np.array_equal(rc.load(saved)[-1].pressure, expected[-1].pressure)
    assert client.get(f"runs/{state['id']}/report.html")[:15].lower() == b"<!doctype html>"


def test_states_are_drawn_when_they_are_looked_at(client):
    state = client.wait(client.post("api/runs", YIELDS)["id"])
    course, *panels = (one for one in state["outputs"] if one["role"] == "picture")
    assert client.get(f"runs/{state['id']}/{course['file']}")[:4] == b"\x89PNG"
    assert [one["panel"] for one in panels] == ["pressure", "gap"]
    assert panels[0]["states"] == ["state 1, 4 N", "state 2, 0 N", "state 3, 2 N", "state 4, 4 N"]
    asked = {"run": state["id"], "panel": "pressure"}
    drawn = [
        client.get("pictures/" + client.post("api/state", {**asked, "state": one})["picture"]) for one in (1, 3, 4)
    ]
    assert all(one[:4] == b"\x89PNG" for one in drawn)
    assert drawn[0] != drawn[1]
    # The ball carries the load elastically when it is loaded again.
    assert client.post("api/state", {**asked, "panel": "gap", "state": 2})["picture"]
    for wrong in ({"state": 0}, {"state": 5}, {"state": True}, {"state": "1"}, {"panel": "heights"}, {"run": "0"}):
        assert "no picture of such a state" in client.refusal("api/state", {**asked, "state": 1, **wrong})
    assert "no picture of such a state" in client.refusal("api/state", [1])


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (
            {"loads": "4", "sliding": "0 1"},
            "Nothing changes with the sliding distance: give the problem a law that does",
        ),
        ({"loads": "4", "time": "0 1"}, "of wear by 'Laws by which the surfaces change', or a viscoelastic body."),
        ({"law_archard": "yes"}, "Coefficient (archard) is missing: fill it in."),
        ({"law_archard": "yes", "law_archard_coefficient": "-1"}, "The wear coefficient must be"),
        ({"law_archard": "yes", "law_archard_coefficient": "1e-16 m"}, "Archard coefficient: '1e-16 m'"),
        ({**WORN, "sliding": "0 2 1"}, "The sliding along a path must be a list of numbers of m that do not fall"),
        ({**WORN, "loads": "1 2"}, "there are 3 for 'Sliding distances', 2 for a force"),
        ({**WORN, "sliding": "0 1s"}, "Each of the sliding distances: '1s' "),
        ({**WORN, "sliding": "0 -1"}, "Each of the sliding distances must be at least 0, but got -1 m."),
        ({**WORN, "sliding": " ".join(map(str, range(41)))}, "The number of sliding distances must be at most 40"),
        ({**WORN, "path_accuracy": "2"}, "The accuracy of a path must be"),
        ({"loads": "0 1"}, "The first load must be above 0, but got 0 N."),
        ({"loads": "1 -1"}, "Each load must be at least 0, but got -1 N."),
        ({**RELAXES, "layers": "1"}, "Layers beside a viscoelastic body are not known: choose no layers, or another"),
        ({**RELAXES, "moduli": "1"}, "there are 1 moduli and 1 times"),
        ({**RELAXES, "relaxation": ""}, "Each of the relaxation times of the body is missing: fill it in."),
        ({"path": "perhaps"}, "The setting 'path' must be one of no, yes"),
    ],
)
def test_a_path_that_cannot_be_followed_is_refused_before_it_is_solved(client, given, sentence):
    assert sentence in client.refusal("api/plan", {**YIELDS, **given})


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("0 1e-3 10ms; 1 min 2h", "s", [0.0, 1e-3, 1e-2, 60.0, 7200.0]),
        ("1e-3 2e-3s", "ms", [1e-6, 2e-3]),
        ("5", "us", [5e-6]),
    ],
)
def test_values_in_a_list_may_state_their_units(text, unit, expected):
    assert list_values({"time": text, "time_unit": unit}, "time", "times", "time") == expected


def test_a_number_with_an_exponent_has_no_unit():
    settings = read_settings({**WORN, "law_archard_coefficient": "1e-16"})
    assert chosen_laws(settings)[0].coefficient == 1e-16
    assert chosen_laws({**settings, "path": "no"}) == []


def test_laws_come_from_the_registry():
    boxes = laws._list_boxes()
    assert [field.label for field in boxes["archard"].fields] == ["Coefficient, m2/N"]
    # Slip passes on no path of the page, and materials bring what they need.
    assert not {"energy-wear", "flattening", "relaxation", "steady-sliding"} & set(boxes)

    @rc.laws.register("tarnish of a test")
    @attrs.frozen
    class Tarnish(rc.Process):
        """A film that grows in time."""

        thickness: float = attrs.field(metadata={"unit": "m"})
        time: float = attrs.field(metadata={"unit": "s"})
        rates = ("time",)
        remembered = {"film": ("thickness of the film", "m")}  # noqa: RUF012

        def change_gap(self, problem, increment, memory):
            return -memory["film"]

        def remember(self, state, increment, memory):
            return memory

    try:
        box = laws._list_boxes()["tarnish of a test"]
    finally:
        del rc.laws._classes["tarnish of a test"]
    assert box.summary == "a film that grows in time"
    assert [(field.name, field.kind, field.unit) for field in box.fields] == [
        ("thickness", "length", "um"),
        ("time", "time", "s"),
    ]


# A body that flows below its surface, by a plug-in that the page does not name.
FLOWS = {"surface": "sphere", "radius": "1", "side": "65", "cells": "16", "load": "force", "load_unit": "N"}
FLOWS |= {"loads": "2 0", "path": "yes", "material": "plastic", "material_plastic_yield_stress": "1000"}
SWIFT = {"material_plastic_hardening": "swift-hardening", "material_plastic_hardening_swift_hardening_strain": "0.005"}
SWIFT |= {"material_plastic_hardening_swift_hardening_power": "0.2"}
TABLE = {"material_plastic_hardening": "tabulated-hardening"}
TABLE |= {"material_plastic_hardening_tabulated_hardening_strain": "0 0.01 0.1"}
TABLE |= {"material_plastic_hardening_tabulated_hardening_stress": "1 1100MPa 1.25"}
TABLE |= {"material_plastic_hardening_tabulated_hardening_stress_unit": "GPa"}


@pytest.fixture
def volume():
    """The plug-in with the material, without which nothing of it can be tried."""
    return pytest.importorskip("roughcontact_volume")


def test_a_body_that_flows_is_that_of_a_script(client, volume):
    steel = volume.Plastic(210e9, 0.3, 1e9, volume.SwiftHardening(0.005, 0.2))
    problem = rc.ContactProblem(rc.Body(rc.SphereSurface(1e-3), steel), grid=rc.Grid((16, 16), 65e-6))
    expected = problem.path(force=[2.0, 0.0])
    plan = client.post("api/plan", {**FLOWS, **SWIFT})
    assert plan["solves"] == 2
    assert 0.2 < plan["seconds"] < 20.0
    # What flows below the surface counts, at the largest load.
    below = problem.explain(force=2.0).memory
    assert below > problem.plan.memory
    assert plan["memory"].endswith(f"at most {binary(problem.plan.memory + below)}")
    state = client.wait(client.post("api/runs", {**FLOWS, **SWIFT})["id"])
    assert (state["phase"], state["notes"]) == ("done", []), state
    assert all(answer["certified"] for answer in state["answers"])
    values = [{one["name"]: one["value"] for one in answer["quantities"]} for answer in state["answers"]]
    table = expected.table().columns
    for name in ("approach", "plastic_strain", "plastic_depth", "imprint_depth", "residual_stress"):
        assert [one[name.replace("_", " ")] for one in values] == list(table[name])
    panels = {one["panel"]: one for one in state["outputs"] if one["role"] == "picture"}
    assert {"plastic-zone", "residual-stress", "total-stress"} < set(panels)
    drawn = client.post("api/state", {"run": state["id"], "panel": "residual-stress", "state": 2})
    assert client.get(f"pictures/{drawn['picture']}")[:4] == b"\x89PNG"
    # A single load is a first loading, and has the numbers of the flow, too.
    (answer,) = describe_sweep(rc.results.Sweep((expected[0],)), {})
    found = {one["name"]: one["value"] for one in answer["quantities"]}
    assert found["plastic strain"] == table["plastic_strain"][0]
    assert found["contact area"] == expected[0].area().value


@pytest.mark.parametrize("prefix", ["", "counterbody_"])
def test_the_fields_of_a_material_are_those_of_a_script(volume, prefix):
    given = {name: text for name, text in FLOWS.items() if not name.startswith("material")}
    own = {**TABLE, "material": "plastic", "material_plastic_yield_stress": "1", "material_plastic_accuracy": "0.01"}
    own |= {"young": "70", "poisson": "0.33", "material_plastic_yield_stress_unit": "GPa"}
    given |= {"counterbody": "deformable"} | {f"{prefix}{name}": text for name, text in own.items()}
    settings = read_settings(given)
    problem = make_problem(settings, make_scene(settings, None))
    hardening = volume.TabulatedHardening([0.0, 0.01, 0.1], [1e9, 1.1e9, 1.25e9])
    materials = problem.body.material, problem.counterbody.material
    assert materials[prefix == "counterbody_"] == volume.Plastic(70e9, 0.33, 1e9, hardening, accuracy=0.01)
    assert materials[prefix == ""] == rc.Elastic(210e9, 0.3)


@pytest.mark.parametrize(
    ("given", "setting", "sentence"),
    [
        ({"material_plastic_yield_stress": ""}, "_yield_stress", "The yield stress of the body is missing: fill"),
        ({"material_plastic_yield_stress": "-1"}, "_yield_stress", "of the body must be above 0, but got -1 MPa."),
        ({"material_plastic_accuracy": "2"}, "_accuracy", "above 0, at most 1"),
        ({**SWIFT, "material_plastic_hardening_swift_hardening_power": "2"}, "_swift_hardening_power", "at most 1"),
        (
            {**SWIFT, "material_plastic_hardening_swift_hardening_strain": " "},
            "_swift_hardening_strain",
            "The strain of the hardening of the body is missing: fill it in.",
        ),
        (
            {**TABLE, "material_plastic_hardening_tabulated_hardening_stress": "1 1.1"},
            "_tabulated_hardening_strain",
            "A table of hardening has a stress for each strain, but there are 3 strains and 2 stresses.",
        ),
        (
            {**TABLE, "material_plastic_hardening_tabulated_hardening_strain": " ".join(map(str, range(41)))},
            "_tabulated_hardening_strain",
            "The number of values of the strain of the hardening of the body must be at most 40, but got 41.",
        ),
        ({**TABLE, "material_plastic_yield_stress": "900"}, "_tabulated_hardening_strain", "contradicts the yield"),
        ({"counterbody": "deformable", "counterbody_hardness": "2"}, "material", "count its flow twice"),
        ({"layers": "1"}, "layers", "Layers beside a plastic body are not known: choose no layers, or another"),
        ({"adhesion": "exponential"}, "material", "Plastic flow is not solved with 'Adhesion': omit one of them."),
        ({"boundary": "wrapped"}, "material", "A wrapped boundary has the nearest images of the pressure alone"),
        ({"poisson": "0.5"}, "material", "a Poisson's ratio below 0.5"),
        ({"load": "fretting"}, "material", "Friction with the material 'plastic' is not known: choose another"),
        ({"law_archard": "yes", "law_archard_coefficient": "1e-16"}, "material", "other laws: omit archard."),
    ],
)
def test_what_does_not_fit_a_body_that_flows_is_said_at_its_setting(client, volume, given, setting, sentence):
    refused = client.post("api/plan", {**FLOWS, **given}, 422)
    assert sentence in refused["error"]
    assert not PYTHON.search(refused["error"])
    assert refused["setting"].endswith(setting)


def test_no_other_part_and_no_other_size_is_taken(client, volume):
    wrong = {"material_plastic_yield_stress": "1e99", "material_plastic_hardening": "sphere", "material": "rigid"}
    refused = [client.refusal("api/plan", {**FLOWS, name: text}) for name, text in wrong.items()]
    assert "but got 1e99 MPa: check its unit." in refused[0]
    assert "must be one of none, linear-hardening, " in refused[1]
    assert "must be one of elastic, viscoelastic, " in refused[2]


class Filler(rc.typing.Part):
    """What fills a sponge."""


@attrs.frozen
class Sand(Filler):
    """Grains."""

    grain: float = attrs.field(metadata={"unit": "m"})
    shape: dict = attrs.field(factory=dict)


@attrs.frozen
class Sponge(rc.Material):
    """A material of a test."""

    young: float = attrs.field(metadata={"unit": "Pa"})
    strengths: tuple[float, ...] = attrs.field(metadata={"unit": "Pa"})
    filler: Filler
    lifetime: float | None = attrs.field(default=None, metadata={"unit": "s"})
    wetness: float = 0.5
    colour: str = "yellow"

    compliance = property(lambda self: 1.0 / self.young)
    pressure_limit = property(lambda self: math.inf)


@attrs.frozen
class Cloth(Sponge):
    """One that needs a word, for which the page cannot ask."""

    weave: str = attrs.field(kw_only=True)


def test_materials_come_from_the_registry(monkeypatch):
    rc.materials.register("sponge of a test")(Sponge)
    rc.materials.register("cloth of a test")(Cloth)
    monkeypatch.setattr(materials, "find_parts", lambda kind: {"sand": Sand} if kind is Filler else {})
    try:
        forms = materials._list_forms()
    finally:
        del rc.materials._classes["sponge of a test"], rc.materials._classes["cloth of a test"]
    assert "cloth of a test" not in forms
    form = forms["sponge of a test"]
    assert (form.label, form.summary, form.shared) == ("sponge of a test", "a material of a test", ("young",))
    strengths, filler, lifetime, wetness = form.fields
    assert (strengths.field.kind, strengths.is_list, strengths.is_needed) == ("pressure", True, True)
    assert filler.choices == ("sand",)
    assert [one.field.name for one in filler.parts[0].fields] == ["grain"]
    assert (lifetime.field.label, lifetime.field.kind) == ("Lifetime (empty: none)", "time")
    assert (wetness.field.label, wetness.is_needed) == ("Wetness (empty: 0.5)", False)
    assert materials.list_material_choices({"sponge": form}) == {"material_sponge_of_a_test_filler": ("sand",)}


def test_the_progress_of_a_path_only_grows(tmp_path):
    sent = []
    work.run({"kind": "solve", "upload": None, "settings": WORN, "folder": str(tmp_path)}, sent.append)
    fractions = [one["fraction"] for one in sent if one.get("phase") == "solving"]
    assert len(fractions) > 3
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


def test_unloading_is_remembered_on_a_path_alone(client):
    """Each load of several is a first loading, as long as they are no path."""
    single = client.wait(client.post("api/runs", {**YIELDS, "path": "no", "loads": "4 2"})["id"])
    path = client.wait(client.post("api/runs", {**YIELDS, "loads": "4 2"})["id"])
    unloaded = [{one["name"]: one["value"] for one in state["answers"][1]["quantities"]} for state in (single, path)]
    assert unloaded[1]["approach"] > unloaded[0]["approach"]


def test_unlike_materials_that_yield_are_followed(client):
    state = client.wait(client.post("api/runs", {**FRETTING, "counterbody": "rigid", "hardness": "0.5"})["id"])
    assert state["phase"] == "done", state
    assert all(one["certified"] for one in state["answers"])


@pytest.mark.slow
def test_loads_with_adhesion_follow_each_other_as_in_a_script(client):
    settings = {**STICKY, "load_unit": "nN", "loads": "20 -20 0", "range": "200"}
    state = client.wait(client.post("api/runs", settings)["id"])
    assert state["phase"] == "done", state
    known = read_settings(settings)
    sweep = make_problem(known, make_scene(known, None)).sweep(force=[20e-9, -20e-9, 0.0])
    quantities = [one for answer in state["answers"] for one in answer["quantities"]]
    areas = [one["value"] for one in quantities if one["name"] == "contact area"]
    assert areas == pytest.approx(sweep.area, rel=1e-4)


@pytest.mark.parametrize(
    ("changed", "is_of_hertz"),
    [
        ({}, True),
        ({"counterbody": "rigid"}, True),
        # It flows, its contact reaches the border, or it is of another contact.
        ({"hardness": "0.5"}, False),
        ({"loads": "80"}, False),
        ({"boundary": "periodic"}, False),
        ({"radius": "0.3", "loads": "100", "hardness": "", "counterbody_hardness": ""}, False),
        ({"surface": "wavy"}, False),
        ({"adhesion": "short-range"}, False),
    ],
)
def test_hertz_stands_beside_the_contact_that_it_is_of(changed, is_of_hertz):
    settings = read_settings({**FIRST, "cells": "64", **changed})
    problem = make_problem(settings, make_scene(settings, None))
    (answer,) = describe_solutions([problem.solve(force=float(settings["loads"]))])
    values = {one["name"]: one["value"] for one in answer["quantities"]}
    known = answer["closed_form"]
    assert bool(known) is is_of_hertz
    # The approach counts from the touch of the cells, which here lie 0.6 nm below the summit.
    for name, within in {"contact area": 1e-3, "maximum pressure": 1e-3, "approach": 3e-3}.items() if known else ():
        assert values[name] == pytest.approx(known[name], rel=within), name


def test_the_first_settings_are_a_problem_that_can_be_solved():
    settings = read_settings(DEFAULTS)
    problem = make_problem(settings, make_scene(settings, None))
    assert [str(load) for load in make_loads(settings, problem)] == ["pressure 100 MPa"]


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"young": "-5"}, "Young's modulus of the body must be above 0, but got -5 GPa."),
        ({"hardness": "-1"}, "The hardness of the body must be above 0, but got -1 GPa."),
        ({**SMALL, "amplitude": "-2"}, "The amplitude must be at least 0, but got -2 µm."),
        ({"loads": "1 0", "load": "force", "load_unit": "uN"}, "Each load must be above 0, but got 0 µN."),
        (
            {"loads": "1e30", "load": "force", "load_unit": "N"},
            "The load must be between 1e-18 N and 1e+15 N, but got 1e30 N: check its unit.",
        ),
        ({"young": "1e300"}, "Young's modulus of the body must be between 1 nPa and 1e+18 Pa, but got 1e300 GPa: "),
        ({"surface": "self-affine", "shortest": "100"}, "The shortest wavelength, 100 µm, must not be above the long"),
        (
            {"surface": "self-affine", "cells": "64", "shortest": "0.1"},
            "The shortest wavelength must be at least two cells (3.125 µm) on this grid, but got 100 nm. Refine",
        ),
        ({"surface": "sphere", "radius": "0.01"}, "The sphere of radius 10 µm does not cover the domain of 100 µm x"),
    ],
)  # fmt: skip
def test_refusals_have_the_numbers_and_units_of_the_page(client, given, sentence):
    assert sentence in client.refusal("api/plan", given)


def test_typical_materials_are_those_of_the_library(client):
    found = json.loads(client.get("api/start"))["typical"]
    units = {"young_unit": "GPa", "hardness_unit": "GPa"}
    assert found["glass"] == {"material": "elastic", "young": "70", "poisson": "0.22", "hardness": "5.5", **units}
    assert found["rubber"] == {"material": "elastic", "young": "0.004", "poisson": "0.495", "hardness": "", **units}
    for name, texts in found.items():
        settings = read_settings({**texts, "surface": "sphere", "cells": "8"})
        assert make_problem(settings, make_scene(settings, None)).body.material == TYPICAL[name]
    assert rc.Body(rc.FlatSurface(), "glass").material.hardness == 5.5e9


def test_warnings_read_as_in_a_script():
    tilted = rc.HeightMap(np.linspace(0.0, 2e-6, 64)[:, None] + 1e-8 * np.random.default_rng(0).random((64, 64)), 1e-4)
    solution = rc.ContactProblem(rc.Body(tilted, rc.Elastic(210e9, 0.3))).solve(force=0.1)
    (warning,) = (text for text in solution.warnings if "tilt" in text)
    (shown,) = (text for text in describe_solutions([solution])[0]["warnings"] if "tilt" in text)
    assert shown == warning
    assert not PYTHON.search(shown)


# Calls, arguments, names and types of Python.
PYTHON = re.compile(r"\w\(\)|\w+=|\w\(\w+|\b\w+_\w+\b|float\d\d|\(\d+,|\b(?:numpy|pandas|scipy|rc)\.|[a-z][A-Z][a-z]")


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.csv", b"1,2,3\n4,5\n", "if those lines are a header, delete them."),
        ("a.csv", b"1 2 3\n4 5 x\n", "comments behind #; delete lines that are not heights."),
        ("a.csv", b"1.5;2.5\n3.5;4,5\n", "comments behind #; write decimals with points."),
        ("a.csv", b"\n".join(b"%d" % (n**2) for n in range(99)), "bring them into that shape and save them again."),
        ("a.csv", b"\n".join(b"%d,%d,%d,5" % (n, n**2, n**3 % 7) for n in range(30)), "save the heights without them"),
        ("a.csv", b"\n".join(b"%d.1,%d.3,%d" % (n**3 % 31, n**2, n) for n in range(30)), "interpolate them on one"),
        ("a.npy", PICKLED, "The file a.npy cannot be read as a height map"),
        ("a.npy", PICKLED.replace(b"|O", b"<c16"), "The file a.npy cannot be read as a height map"),
        ("a.npz", None, "a saved solution, not a height map: the command 'roughcontact plot a.npz' draws it."),
    ],
)  # fmt: skip
def test_refusals_of_files_speak_no_python(client, solved_file, name, content, said):
    status, answer = client.upload(name, solved_file if content is None else content)
    assert status == 422, answer
    assert said in answer["error"]
    assert not PYTHON.search(answer["error"]), answer["error"]


@pytest.fixture(scope="module")
def solved_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("solved") / "solution.npz"
    body = rc.Body(rc.WavySurface(0.5e-6, 25e-6), rc.Elastic(210e9, 0.3))
    rc.ContactProblem(body, grid=rc.Grid((16, 16), 50e-6), boundary="periodic").solve(pressure=50e6).save(path)
    return path.read_bytes()


@pytest.mark.parametrize("boundary", ["free", "periodic", "wrapped"])
def test_plan_and_status_speak_no_python(client, boundary):
    plan = client.post("api/plan", {**SMALL, "boundary": boundary, "amplitude": "9e3", "hardness": "2"})
    assert "Projected Conjugate Gradient, tolerance 1e-05" in plan["text"]
    assert plan["warnings"][0].endswith("check them, and the unit of heights from a file.")
    assert "on the command line" not in plan["text"]
    for text in (plan["text"], *plan["warnings"], *(in_words_of_page(str(status)) for status in rc.Status)):
        assert not PYTHON.search(text), text
    assert client.refusal("api/plan", {**SMALL, "cells": "1"}).endswith("at least two cells, but got 1 x 1.")


def test_the_saturated_area_warns_on_the_page_and_in_its_table():
    surface = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=3e-6, longest=48e-6, seed=1)
    body = rc.Body(surface, rc.ElasticPerfectlyPlastic(210e9, 0.3, 7e9))
    problem = rc.ContactProblem(body, grid=rc.Grid((48, 48), 48e-6), boundary="periodic")
    solution = problem.solve(force=1.0)
    warnings = list_quantities(solution)[1]
    found = [text for text in warnings if text.startswith("The saturated area is uncertain: ")]
    assert found
    (answer,) = describe_solutions([solution])
    assert answer["warnings"] == [f"{text.rstrip('.')}." for text in warnings]
    assert found[0] in make_table([answer])
    force = {**answer["quantities"][3], "value": 5 - 1e-15}
    assert "\r\n5.0,0.0,converged" in make_table([{**answer, "quantities": [force]}])


@pytest.mark.parametrize(
    ("material", "force", "warned"),
    [
        (rc.Elastic(210e9, 0.3), 20.0, True),
        (rc.Elastic(210e9, 0.3), 0.01, False),
        (rc.ElasticPerfectlyPlastic(210e9, 0.3, 7e9), 20.0, False),
        (rc.Elastic(3e9, 0.4), 1.0, False),
    ],
)
def test_more_pressure_than_metals_bear_asks_for_the_hardness(material, force, warned):
    ball = rc.Body(rc.SphereSurface(1e-4), material)
    solution = rc.ContactProblem(ball, grid=rc.Grid((48, 48), 1e-4)).solve(force=force)
    (answer,) = describe_solutions([solution])
    said = [
        text for text in answer["warnings"] if text.endswith("than metals bear: unless it is meant, give a hardness.")
    ]
    assert len(said) == warned


def test_a_column_of_a_sweep_has_one_unit():
    column = [rc.Estimate(value, 8e-12, "m2") for value in (0.0, 5.314e-9, 1.001e-8)]
    assert write_column(column) == ["0.0 ± 8.0 µm²", "5314.0 ± 8.0 µm²", "10010.0 ± 8.0 µm²"]
    assert write_column([rc.Estimate(value, 0.0, "N") for value in (0.5, 5 - 1e-15, 10.0)]) == ["0.5 N", "5 N", "10 N"]


def test_a_warning_of_several_loads_is_said_once_with_them():
    edge, fine = "The maximum is uncertain: it lies at an edge.", "About 3.7 cells."
    found = gather_warnings([("5 N", [edge]), ("10 N", [edge, "About 3.9 cells."]), ("20 N", [edge, fine])])
    assert found == [f"At 5 N, 10 N and 20 N: {edge}", f"At 10 N and 20 N (here with the numbers at 20 N): {fine}"]
    assert gather_warnings([("5 N", [edge])]) == [edge]
    assert gather_warnings([(f"{load} N", [edge]) for load in range(4)]) == [f"At all 4 loads: {edge}"]
    assert gather_warnings([("5 N", []), ("10 N", [edge])]) == [f"At 10 N: {edge}"]


def test_progress_only_grows_and_counts_the_loads(monkeypatch):
    monkeypatch.setattr("roughcontact_app.progress._INTERVAL", 0.0)
    sent = []
    progress = Progress((64, 64), 2, 1e-5, sent.append)
    for load in ("force 1 N", "force 2 N"):
        progress.begin(load)
        for shape, error in (((32, 32), 1e-3), ((64, 64), 1e-1), ((64, 64), 3e-1), ((64, 64), 1e-5), ((64, 64), 0.0)):
            progress.step(Step(shape, 1, error))
    fractions = [event["fraction"] for event in sent]
    assert fractions == sorted(fractions)
    assert fractions[4] == 0.5
    assert fractions[-1] == 1.0
    assert sent[0]["text"].startswith("load 1 of 2, force 1 N: 32 x 32 cells")


@contextmanager
def command(folder, *options, **environment):
    """The command ``roughcontact app`` with its files in a folder, and the address that it prints."""
    arguments = [sys.executable, "-m", "roughcontact", "app", *options]
    environment = {**os.environ, "TMPDIR": str(folder), **environment}
    started = subprocess.Popen(
        arguments,
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
        preexec_fn=heed_signals if os.name == "posix" else None,
    )
    with started as process:
        try:
            yield process, re.search(r"http://127\.0\.0\.1:\d+/\S+/", process.stdout.readline())[0]
        finally:
            process.kill()


def heed_signals():
    """Heed the signals that what runs the tests may ignore, as nohup and shells do for what runs behind."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)


def list_sessions(folder):
    return set(folder.glob("roughcontact-app-*"))


@pytest.mark.parametrize("name", ["SIGTERM", "SIGQUIT"])
def test_the_command_serves_until_it_is_ended(tmp_path, name):
    with command(tmp_path, "--no-browser") as (process, address):
        with urllib.request.urlopen(address, timeout=PATIENCE) as answer:
            assert answer.status == 200
        assert len(list_sessions(tmp_path)) == 1
        process.send_signal(getattr(signal, name))
        assert "files are removed" in process.communicate(timeout=PATIENCE)[0]
        assert process.returncode == 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="there are no such terminals")
def test_the_files_go_with_the_terminal(tmp_path):
    import pty

    process, terminal = pty.fork()
    if not process:
        heed_signals()
        environment = {**os.environ, "TMPDIR": str(tmp_path)}
        os.execve(sys.executable, [sys.executable, "-m", "roughcontact", "app", "--no-browser"], environment)
    try:
        assert b"The page is at" in os.read(terminal, 4096)
        assert len(list_sessions(tmp_path)) == 1
    finally:
        os.close(terminal)
    ended = time.monotonic() + PATIENCE
    while (status := os.waitpid(process, os.WNOHANG)) == (0, 0) and time.monotonic() < ended:
        time.sleep(0.05)
    if status == (0, 0):
        os.kill(process, signal.SIGKILL)
    assert status == (process, 0)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="locks of files are different there")
def test_what_a_killed_command_left_goes_at_the_next_start_and_a_living_one_keeps_its_own(tmp_path):
    with command(tmp_path, "--no-browser") as (killed, _), command(tmp_path, "--no-browser") as (_, address):
        with urllib.request.urlopen(f"{address}api/start", timeout=PATIENCE):
            assert len(list_sessions(tmp_path)) == 2
        # Not of this command, of another machine, and a link: they stay.
        foreign = [tmp_path / f"roughcontact-app-{name}" for name in ("other", "machine", "link")]
        for folder in foreign[:2]:
            folder.mkdir()
        (foreign[1] / "lock").write_text("of another machine")
        foreign[2].symlink_to(foreign[1])
        killed.kill()
        killed.wait(PATIENCE)
        before = list_sessions(tmp_path)
        assert len(before) == 5
        with command(tmp_path, "--no-browser"):
            now = list_sessions(tmp_path)
            assert len(now - before) == 1
            assert len(before - now) == 1
            assert now.issuperset(foreign)
        with urllib.request.urlopen(address, timeout=PATIENCE) as answer:
            assert answer.status == 200


@pytest.mark.skipif(sys.platform == "win32", reason="there no user sees the commands of another")
def test_the_command_line_of_the_browser_gives_no_access(tmp_path):
    seen, browser = tmp_path / "seen", tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\nprintf "%s\\n" "$@" > {seen}.new && mv {seen}.new {seen}\n')
    browser.chmod(0o755)
    with command(tmp_path, BROWSER=str(browser)) as (process, address):
        wait_until(seen.exists)
        (shown,) = seen.read_text().splitlines()
        assert address.split("/")[3] not in shown
        page = Path(urllib.request.url2pathname(urllib.parse.urlsplit(shown).path))
        # Nobody else may read the file; it leads to the address that is printed, which works any time.
        assert stat.S_IMODE(page.stat().st_mode) == 0o600
        assert f'content="0; url={address}"' in page.read_text()
        if os.getuid() == 0:
            for folder in (tmp_path, *tmp_path.parents[:2]):
                folder.chmod(0o755)
            nobody = subprocess.run(["cat", str(page)], user=65534, capture_output=True, check=False)
            assert b"Permission denied" in nobody.stderr
        process.terminate()
        process.wait(PATIENCE)
        assert not page.exists()


def test_browsers_in_a_snap_are_given_a_file_that_they_see(tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("roughcontact_app.command._SNAPS", tmp_path)
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("pathlib.Path.home", lambda: tmp_path)
    with _shown("http://127.0.0.1:1/x/", tmp_path / "hidden"):
        wait_until(lambda: opened)
        (page,) = tmp_path.glob("[!.]*.html")
        assert opened == [page.as_uri()]
        assert os.name == "nt" or stat.S_IMODE(page.stat().st_mode) == 0o600
    assert list(tmp_path.iterdir()) == []


def test_a_port_in_use_is_said_so(server, capsys):
    from roughcontact.__main__ import main

    assert main(["app", "--no-browser", "--port", str(server.server_port)]) == 2
    assert "choose another, or omit --port" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["app", "--no-browser", "--port", "70000"])
    assert "'70000' is not a port from 0 to 65535" in capsys.readouterr().err


def test_the_page_uses_public_names_alone():
    package = Path(sys.modules["roughcontact_app"].__file__).parent
    private = re.compile(r"\broughcontact\._|\bfrom roughcontact import .*\b_[a-z]")
    found = {file.name: private.findall(file.read_text(encoding="utf-8")) for file in package.glob("*.py")}
    assert found
    assert not any(found.values())


def test_the_page_warns_of_a_tilt_from_the_bound_of_solutions():
    assert PLAUSIBILITY_RULES["tilt"].admissible == preview._ADMISSIBLE_TILT


def test_each_answer_tells_how_much_other_places_differ():
    rough = rc.SelfAffineSurface(hurst=0.8, rms_slope=0.1, shortest=8e-6, longest=32e-6)
    body = rc.Body(rough, rc.Elastic(young=210e9, poisson=0.3))
    problem = rc.ContactProblem(body, grid=rc.Grid((32, 32), 64e-6), boundary="periodic")
    solutions = list(problem.sweep(pressure=[50e6, 100e6]))
    stiffness = [solution.stiffness() for solution in solutions]
    found = describe_solutions(solutions, {"stiffness": stiffness})
    for solution, stiff, answer in zip(solutions, stiffness, found, strict=True):
        for name, one in {
            "contact area": solution.area(), "maximum pressure": solution.peak_pressure(), "stiffness": stiff,
        }.items():  # fmt: skip
            assert f"{name} ± {100.0 * one.sampling / one.value:.2g} %" in answer["places"]
        # The sentence of the print, with its reasons.
        (line,) = (line for line in str(solution).replace("+-", "±").splitlines() if line.startswith("other places"))
        assert line.split("contact area ")[1].split(",")[0] in answer["places"]
    plain = rc.ContactProblem(
        rc.Body(rc.WavySurface(0.5e-6, 25e-6), rc.Elastic(210e9, 0.3)), grid=rc.Grid((32, 32), 50e-6)
    )
    assert describe_solutions([plain.solve(force=0.1)])[0]["places"] == ""


def test_the_help_of_the_command_line_loads_no_session():
    script = "import sys; from roughcontact.__main__ import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    script += "print('roughcontact_app.session' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    *text, loaded = done.stdout.splitlines()
    assert any(line.startswith("  app ") for line in text)
    assert loaded == "False"
