"""Each way in that is not the operator's own browser, tried."""

import http.client
import json
import multiprocessing
import os
import shutil
import socket
import ssl
import subprocess
import sys
import tempfile
import urllib.request
from pathlib import Path

import pytest

from slipscale.commands import main
from slipscale.experiments.lab.console import serve as serving
from slipscale.experiments.lab.console.presence import Presence
from slipscale.experiments.lab.console.security import LARGEST_BODY, POLICY, Access
from slipscale.faults import UserError
from slipscale.faults.private_folder import private_folder

PAGES = ("/", "/live", "/study", "/data", "/pilot", "/events", "/static/console.js")
BODY = json.dumps({}).encode()
PATIENCE_S = 300


def test_only_this_computer_is_listened_to(visitor):
    assert visitor.access.host == "127.0.0.1"
    with serving._listen(visitor.access.host, 0) as listening:
        assert listening.getsockname()[0] == "127.0.0.1"


@pytest.mark.parametrize("path", [*PAGES, "/data/download", "/data/report", "/nothing"])
def test_without_the_token_nothing_is_shown(visitor, path):
    visitor.client.cookies.clear()
    answer = visitor.client.get(path)
    assert (answer.status_code, "slipscale lab" in answer.text) == (403, True)


@pytest.mark.parametrize("token", ["", "guess", "é", "0" * 5000])
def test_a_guessed_token_opens_nothing(visitor, token):
    visitor.client.cookies.clear()
    assert visitor.client.get("/", params={"token": token}).status_code == 403
    header = {"cookie": f"{visitor.access.cookie}={token.encode().hex()}"}
    assert visitor.client.get("/", headers=header).status_code == 403


def test_the_address_gives_a_cookie_that_no_script_and_no_other_site_sees(visitor):
    visitor.client.cookies.clear()
    token = visitor.access.entrance.token
    answer = visitor.client.get("/", params={"token": token})
    assert (answer.status_code, "0;url=/" in answer.text) == (200, True)
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert token not in cookie
    assert visitor.client.get("/").status_code == 200


def test_an_address_opens_one_browser_and_the_next_address_another(visitor):
    visitor.client.cookies.clear()
    told = []
    entrance = visitor.access.entrance
    entrance.renewed = lambda: told.append(entrance.token)
    first = entrance.token
    statuses = []
    for token in (first, first, entrance.secret):
        statuses.append(visitor.client.get("/", params={"token": token}).status_code)
        visitor.client.cookies.clear()
    assert statuses == [200, 403, 403]
    assert told != [first]
    assert visitor.client.get("/", params={"token": told[0]}).status_code == 200


@pytest.mark.parametrize("path", ["//evil.example/..", "/%5C%5Cevil.example"])
def test_a_token_leads_to_no_other_site(visitor, path):
    answer = visitor.client.get(path, params={"token": visitor.access.entrance.token})
    assert "location" not in answer.headers
    assert "evil" not in answer.text


def test_tokens_and_secrets_are_new_each_time_and_stand_in_no_repr():
    one, other = Access(port=1), Access(port=1)
    told = [each.entrance.token for each in (one, other)]
    told += [each.entrance.secret for each in (one, other)]
    assert len(set(told)) == 4
    assert not any(each in repr(one) for each in told)


@pytest.fixture
def served(lab):
    """Serve a console in a process of its own; yield the address and the door's folder."""
    words = [sys.executable, "-P", "-m", "slipscale", "lab", "--no-browser", "--port", "0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, cwd=lab) as process:
        yield process.stdout.readline().split()[-1]
        process.terminate()


def test_a_websocket_request_prints_nothing_on_the_operators_terminal(lab):
    words = [sys.executable, "-P", "-m", "slipscale", "lab", "--no-browser", "--port", "0"]
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=lab
    ) as process:
        host = process.stdout.readline().split()[-1].removeprefix("http://").partition("/")[0]
        line = http.client.HTTPConnection(host, timeout=PATIENCE_S)
        upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
        line.request(
            "GET", "/", headers=upgrade | {"Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA=="}
        )
        assert line.getresponse().status < 500
        line.close()
        process.terminate()
        (heading,) = process.communicate()[1].splitlines()
        assert heading.startswith("defaults: ")


def _ask_as(user, address, told):
    "x".encode("idna")  # loaded while its file can be read
    os.setuid(user)
    host, _, path = address.removeprefix("http://").partition("/")
    line = http.client.HTTPConnection(host, timeout=PATIENCE_S)
    line.request("GET", f"/{path}")
    answer = line.getresponse()
    told.put((answer.status, answer.read().decode()))


@pytest.mark.skipif(os.name != "posix" or os.getuid() != 0, reason="needs to become another user")
def test_another_user_of_this_computer_is_refused_whatever_they_hold(served):
    """They have read the token, and this is their only try."""
    context = multiprocessing.get_context("fork")
    answers = []
    for user in (65534, 0):
        told = context.Queue()
        asking = context.Process(target=_ask_as, args=(user, served, told))
        asking.start()
        answers.append(told.get(timeout=PATIENCE_S))
        asking.join()
    assert answers[0] == (403, "This console belongs to another user.\n")
    assert answers[1][0] == 200


def test_a_connection_on_which_nothing_is_asked_is_closed(served, monkeypatch):
    host, _, port = served.removeprefix("http://").partition("/")[0].partition(":")
    with socket.create_connection((host, int(port)), timeout=PATIENCE_S) as idle:
        idle.sendall(b"GET / HTTP/1.1\r\n")
        assert idle.recv(1) == b""


def test_a_browser_is_opened_by_a_file_that_only_its_owner_can_read(lab, monkeypatch):
    """A program's arguments can be read by every user of the computer."""
    found = []

    def note(address):
        path = Path(address.removeprefix("file://"))
        found.append((address, path.stat().st_mode & 0o777, path.read_text(encoding="utf-8")))
        return True

    monkeypatch.setattr(serving.webbrowser, "open", note)
    monkeypatch.setattr(serving._Server, "run", lambda *_, **__: None)
    serving.serve(port=0, lan=None, browser=True)
    ((address, mode, text),) = found
    assert "token" not in address
    assert mode == 0o600
    assert "?token=" in text
    assert not list(Path(os.environ["XDG_RUNTIME_DIR"]).rglob("*.html"))


def test_other_users_cannot_stop_the_console_by_files_they_make(lab, monkeypatch):
    """Names in the temporary folder can be guessed and taken; the console uses none there."""
    monkeypatch.setattr(tempfile, "gettempdir", lambda: pytest.fail("the folder is everybody's"))
    presence = Presence(lab, 8470)
    presence.announce()
    assert presence.first()
    presence.close()


@pytest.mark.skipif(os.name != "posix", reason="rights of POSIX")
def test_a_folder_that_others_can_write_is_not_used(lab, monkeypatch):
    open_to_all = Path(os.environ["XDG_RUNTIME_DIR"], "slipscale")
    open_to_all.mkdir()
    open_to_all.chmod(0o777)
    monkeypatch.setenv("HOME", str(lab))
    assert private_folder() == lab / ".cache/slipscale"
    private_folder().chmod(0o750)
    with pytest.raises(UserError, match="chmod 700"):
        private_folder()


@pytest.mark.parametrize(
    "host", ["evil.example:8470", "127.0.0.1", "127.0.0.1:80", "localhost.evil.example:8470", ""]
)
def test_a_foreign_name_for_this_machine_is_refused(visitor, host):
    """DNS rebinding: a page of evil.example whose name now means 127.0.0.1."""
    for path in PAGES:
        assert visitor.client.get(path, headers={"host": host}).status_code == 400


@pytest.mark.parametrize(
    "changes",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": None},
        {"origin": "https://127.0.0.1:8470"},
        {"origin": "http://127.0.0.1:8471"},
        {"x-slipscale": None},
        {"content-type": "text/plain"},
        {"content-type": "application/x-www-form-urlencoded"},
    ],
)
def test_a_form_or_script_of_another_page_changes_nothing(visitor, asking, changes):
    headers = {key: value for key, value in (asking | changes).items() if value is not None}
    answer = visitor.client.post("/do/check", content=BODY, headers=headers)
    assert answer.status_code == 403
    assert visitor.jobs.started == []
    assert visitor.client.post("/do/check", content=BODY, headers=asking).status_code == 200


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE"])
def test_other_methods_are_refused(visitor, asking, method):
    assert visitor.client.request(method, "/do/check", headers=asking).status_code == 403


def test_a_body_without_end_is_not_read(visitor, asking):
    long = asking | {"content-length": str(LARGEST_BODY + 1)}
    assert visitor.client.post("/do/check", content=b"{}", headers=long).status_code == 403


@pytest.mark.parametrize("path", PAGES[:5])
def test_a_page_may_run_and_load_only_the_consoles_own(visitor, path):
    answer = visitor.client.get(path)
    assert answer.headers["content-security-policy"] == POLICY
    assert "default-src 'none'" in POLICY
    assert answer.headers["cache-control"] == "no-store"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert "http://" not in answer.text.replace("http://www.w3.org", "")
    assert "https://" not in answer.text
    assert "style=" not in answer.text
    assert "<script>" not in answer.text


@pytest.mark.parametrize(
    "path",
    [
        "/static/../app.py",
        "/static/..%2fapp.py",
        "/static/%2e%2e/app.py",
        "/static/app.py",
        "/pilot/..%2f..%2fdata/report",
        "/pilot/../report.html",
        "/data/participants.tsv",
        "/data/../slipscale.toml",
    ],
)
def test_no_path_comes_from_the_page(visitor, recorded, path):
    answer = visitor.client.get(path, headers={"accept-language": "fr"})
    assert (answer.status_code, "Page introuvable" in answer.text) == (404, True)


@pytest.mark.parametrize(
    "action, fields",
    [
        ("begin", {"participant": "../../etc"}),
        ("begin", {"participant": "--help"}),
        ("resume", {"participant": "02", "session": "../x", "run": "01"}),
        ("copy", {"name": "../evil", "text": ""}),
        ("copy", {"name": ".bashrc", "text": ""}),
        ("copy", {"name": "a/b", "text": ""}),
        ("pilot", {"participants": 1, "seed": 1, "out": "/root"}),
        ("pilot", {"participants": "1; rm -rf", "seed": 1}),
        ("analyse", {"dataset": "/"}),
        ("nothing", {}),
    ],
)
def test_words_that_would_be_paths_or_options_are_refused(visitor, recorded, action, fields):
    before = sorted(path.as_posix() for path in recorded.parent.rglob("*"))
    status, _ = visitor.ask(action, **fields)
    assert status == 409
    assert visitor.jobs.started == []
    assert sorted(path.as_posix() for path in recorded.parent.rglob("*")) == before


@pytest.mark.parametrize(
    "sent", [b"", b"[", b"null", b"[]", b'"x"', b"\xff", b'{"participant": 1}']
)
def test_what_is_no_form_is_refused(visitor, asking, sent):
    answer = visitor.client.post("/do/begin", content=sent, headers=asking)
    assert answer.status_code == 409
    assert visitor.jobs.started == []


def test_what_people_wrote_is_text_and_never_markup(visitor, recorded, lab):
    (lab / "slipscale.toml").write_text('study = "<script>alert(1)</script>"\n')
    page = visitor.see("/")
    assert "&lt;script&gt;" in page
    assert "<script>alert" not in page


def test_a_report_runs_nothing_and_is_framed_by_the_console_alone(visitor, lab, recorded):
    folder = lab / "pilots/001/derivatives/slipscale"
    folder.mkdir(parents=True)
    (folder / "report.html").write_text("<script>1</script>")
    policy = visitor.client.get("/pilot/001/report.html").headers["content-security-policy"]
    assert policy.startswith("sandbox; default-src 'none'")
    assert "script-src" not in policy
    assert "frame-ancestors 'self'" in policy


@pytest.fixture
def phone(lab, make_visitor):
    """A phone in the laboratory's network."""
    return make_visitor(Access(host="192.168.0.12", port=8470, tls=True, read_only=True))


def test_in_the_network_the_console_only_shows(phone, recorded, asking):
    headers = asking | {"origin": "https://192.168.0.12:8470"}
    for action in ("begin", "ask", "check", "save", "unblind"):
        answer = phone.client.post(f"/do/{action}", content=BODY, headers=headers)
        assert (answer.status_code, answer.text) == (403, "This console is read-only.\n")
    for path in PAGES[:5]:
        page = phone.see(path)
        assert "data-do=" not in page
        assert "data-study=" not in page
    assert phone.client.get("/data/download").status_code == 404


def test_in_the_network_its_cookie_goes_through_tls_only(phone):
    phone.client.cookies.clear()
    answer = phone.client.get("/", params={"token": phone.access.entrance.token})
    assert "Secure" in answer.headers["set-cookie"]


@pytest.mark.parametrize(
    "address", ["0" + ".0" * 3, "8.8.8.8", "everything", "::1", "192.168.0.1/24"]
)
def test_an_address_that_is_nobodys_choice_is_refused(lab, capsys, address):
    assert main(["lab", "--lan", address, "--no-browser"]) == 2
    assert "expected this computer's own address" in capsys.readouterr().err


@pytest.mark.skipif(not shutil.which("openssl"), reason="makes the certificate")
def test_the_certificate_is_for_the_address_and_plain_http_is_not_served(lab, tmp_path):
    code = (
        "import sys; from slipscale.experiments.lab.console.serve import serve; "
        "serve(port=0, lan='127.0.0.1', browser=False)"
    )
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", code], stdout=subprocess.PIPE, text=True, cwd=lab
    )
    with process:
        try:
            address = process.stdout.readline().split()[-1]
            assert address.startswith("https://127.0.0.1:")
            assert "read-only" in process.stdout.readline()
            context = ssl.create_default_context()
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
            request = urllib.request.Request(address, method="GET")  # noqa: S310 - our own address
            opener = urllib.request.build_opener(
                urllib.request.HTTPSHandler(context=context), urllib.request.HTTPCookieProcessor()
            )
            opener.open(request, timeout=PATIENCE_S).close()
            with opener.open(address.partition("?")[0], timeout=PATIENCE_S) as answer:
                assert "read-only" in answer.read().decode()
            with (
                pytest.raises(OSError, match=r".*"),
                opener.open(address.replace("https", "http"), timeout=PATIENCE_S) as plain,
            ):
                plain.read()
        finally:
            process.terminate()


def test_a_port_that_is_taken_is_one_sentence(lab, capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["lab", "--no-browser", "--port", str(port)]) == 2
    assert "another console" in capsys.readouterr().err
    assert main(["lab", "--no-browser", "--port", "99999"]) == 2
    assert "from 0 to 65535" in capsys.readouterr().err


def test_without_openssl_the_network_is_refused_with_another_way(tmp_path, monkeypatch):
    monkeypatch.setattr(serving.shutil, "which", lambda _: None)
    with pytest.raises(UserError, match="ssh -L"):
        serving._certificate("192.168.0.12", tmp_path)


def test_without_a_browser_the_address_is_still_said(monkeypatch, capsys):
    monkeypatch.setattr(serving.webbrowser, "open", lambda _: False)
    serving._open("http://127.0.0.1:1/")
    assert "open the address yourself" in capsys.readouterr().err


@pytest.mark.parametrize("asked, kept", [("fr", "/?lang=fr"), ("//evil.example", '"0;url=/"')])
def test_the_language_in_the_address_outlives_the_exchange_of_the_token(visitor, asked, kept):
    token = visitor.access.entrance.token
    answer = visitor.client.get(f"/?token={token}&lang={asked}")
    assert kept in answer.text
    assert "evil" not in answer.text
