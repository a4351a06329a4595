"""The console's pages and actions as an ASGI application."""

from __future__ import annotations

import time
import zipfile
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from functools import partial
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from secrets import token_hex
from threading import Lock
from typing import Any

import anyio
from jinja2 import Environment, PackageLoader, StrictUndefined
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from slipscale.experiments.lab.console.actions.data import renew
from slipscale.experiments.lab.console.actions.desk import Desk
from slipscale.experiments.lab.console.actions.forms import read_form
from slipscale.experiments.lab.console.actions.study_changes import Edit, changed
from slipscale.experiments.lab.console.actions.table import do
from slipscale.experiments.lab.console.jobs import KINDS, Jobs
from slipscale.experiments.lab.console.own_tables import tables
from slipscale.experiments.lab.console.page_texts import Words, catalogue, languages, preferred
from slipscale.experiments.lab.console.pages.data import parts_done
from slipscale.experiments.lab.console.pages.editor import editor, follow_up
from slipscale.experiments.lab.console.pages.strip import strip
from slipscale.experiments.lab.console.pages.table import PAGES, WITHIN
from slipscale.experiments.lab.console.pages.view import View, local_time
from slipscale.experiments.lab.console.presence import Presence
from slipscale.experiments.lab.console.security import REPORT_POLICY, Access, Guard
from slipscale.experiments.lab.console.state import (
    RESULTS,
    State,
    changed_ns,
    export_folder,
    frozen_plans,
    pilots,
)
from slipscale.experiments.session.terminal import clock_face
from slipscale.faults import UserError, harmless

PACKAGE = "slipscale.experiments.lab.console"
LOOK_S = 1.0  # interval between two complete checks for changes
PULSE_S = 0.1  # interval between two checks of the running session and the started jobs
STATIC = {
    "console.css": "text/css",
    "console.js": "text/javascript",
    "icon.svg": "image/svg+xml",
}
NOT_THERE = 404
CANNOT = 409


class Console:
    """The application's state: laboratory folder, started jobs, and whether it is closing."""

    def __init__(self, access: Access, jobs: Jobs) -> None:
        self.access = access
        self.name = token_hex(4)  # identifies pages that an earlier console left open
        self.lab = Path.cwd().name
        self.jobs = jobs
        self.state = State()
        self.desk = Desk(self.state, jobs)
        # A read-only console cannot control the session, so other consoles need not be informed.
        self.presence = None if access.read_only else Presence(Path.cwd(), access.port)
        self.closing = anyio.Event()
        self._computing = Lock()  # one simulation of an edited study at a time
        self._environment = Environment(
            loader=PackageLoader(PACKAGE),
            autoescape=True,
            undefined=StrictUndefined,
            auto_reload=False,  # an update during a session must not mix two versions
            trim_blocks=True,
            lstrip_blocks=True,
        )
        self._environment.filters["local"] = local_time

    # Pages ------------------------------------------------------------------------------------

    async def page(self, request: Request, name: str) -> Response:
        """Return the page with the given name, rendered with the current data."""
        return await run_in_threadpool(self._page, request, name, f"{name}.html", {})

    def _page(self, request: Request, name: str, template: str, more: dict[str, Any]) -> Response:
        """Render a template in the reader's language."""
        view = self._view(request)
        found, t = view.found, view.t
        status = found.live.status if found.live else None
        values: dict[str, Any] = {
            "t": t,
            "page": name,
            "pages": tuple(each for each in PAGES if each not in WITHIN),
            "marked": WITHIN.get(name, name),
            "others": [
                (code, catalogue(code).texts["page.language"])
                for code in languages()
                if code != t.language
            ],
            "found": found,
            "notices": self._notices(),
            "warnings": self.desk.warnings.pending(),
            "strip": strip(found, t, self.lab),
            "clock": clock_face,
            "shown_state": status.state if status else "",
            "read_only": self.access.read_only,
            "console": self.name,
            "under_way": self._under_way(live=found.live is not None),
            "all_shown": "all" in request.query_params,
            **more,
        }
        if template == f"{name}.html":
            values |= PAGES[name](view)
        response = HTMLResponse(self._rendered(template, values))
        if (chosen := request.query_params.get("lang")) in languages():
            response.set_cookie("lang", chosen, samesite="strict", secure=self.access.tls)
        return response

    def _view(self, request: Request) -> View:
        """Return the data for rendering a page, with texts in the reader's language."""
        chosen = request.query_params.get("lang", request.cookies.get("lang", ""))
        t = Words(preferred(request.headers.get("accept-language", ""), chosen))
        return View(found=self.state.now(), jobs=self.jobs, t=t, query=request.query_params)

    def _rendered(self, template: str, values: dict[str, Any]) -> str:
        return self._environment.get_template(template).render(values)

    async def missing(self, request: Request, _: Exception) -> Response:
        """Return the error page for an address that does not exist."""
        response = await run_in_threadpool(self._page, request, "missing", "not_there.html", {})
        response.status_code = NOT_THERE
        return response

    async def edit(self, request: Request) -> Response:
        """Return the edited text of a study, with its errors and form."""
        sent = await request.body()

        def edited(view: View) -> dict[str, Any]:
            asked = read_form(Edit, sent)
            text = changed(asked.text, asked.change) if asked.change else asked.text
            shown = editor(view, text, asked.template)
            html = self._rendered(
                "editor/edit.html", shown | {"t": view.t, "read_only": False, "found": view.found}
            )
            faults = [(each.line, view.t.say(each.whole)) for each in shown["told"]]
            return {"text": text, "html": html, "faults": faults}

        return await self._answer(request, edited)

    async def later(self, request: Request) -> Response:
        """Return the results that take longer to compute: duration, cost and orders."""
        sent = await request.body()

        def followed(view: View) -> dict[str, Any]:
            asked = read_form(Edit, sent)
            with self._computing:
                shown = follow_up(view, asked.text, asked.template)
            return {
                "html": self._rendered(
                    "editor/later.html", shown | {"t": view.t, "found": view.found}
                )
            }

        return await self._answer(request, followed)

    async def _answer(self, request: Request, do: Callable[[View], dict[str, Any]]) -> Response:
        """Return the requested data as JSON, or the reason why they are unavailable."""

        def answered() -> Response:
            view = self._view(request)
            try:
                return JSONResponse(do(view))
            except UserError as error:
                said = view.t.say(harmless(str(error)))
                return JSONResponse({"said": said}, status_code=CANNOT)

        return await run_in_threadpool(answered)

    async def events(self, _: Request) -> Response:
        """Return an event stream that reports every change."""
        return StreamingResponse(
            self._changes(), media_type="text/event-stream", headers={"x-accel-buffering": "no"}
        )

    async def _changes(self) -> AsyncIterator[str]:
        before, looked_s = "", float("-inf")
        pulse = await run_in_threadpool(self._pulse)
        while not self.closing.is_set():
            last, pulse = pulse, await run_in_threadpool(self._pulse)
            if pulse != last or time.monotonic() - looked_s >= LOOK_S:
                looked_s = time.monotonic()
                now = await run_in_threadpool(self._version)
                # Sending a comment keeps the connection open, and fails if the browser has
                # disconnected.
                yield f"data: {now}\n\n" if now != before else ": there\n\n"
                before = now
            with anyio.move_on_after(PULSE_S):
                await self.closing.wait()

    def _pulse(self) -> object:
        """Return a value that changes with the state of the session or of any started job."""
        jobs = (self.jobs.last(kind) for kind in KINDS)
        return self.state.pulse(), [job and job.status for job in jobs]

    def _version(self) -> str:
        if self.presence and self.presence.first():
            renew(self.desk)
        jobs = [self.jobs.last(kind) for kind in KINDS]
        states = [
            (job.status, job.complained(), job.steps(), changed_ns(job.output)) if job else None
            for job in jobs
        ]
        return self.state.version(
            states,
            parts_done(self.state.now(), self.jobs),
            self._notices(),
            self.desk.warnings.pending(),
        )

    def _notices(self) -> tuple[str, ...]:
        return self.state.now().notices + (self.presence.notices() if self.presence else ())

    # Files, whose names are fixed here, so that a page cannot choose a path --------------------

    async def static(self, request: Request) -> Response:
        """Return one of the console's static files."""
        name = request.path_params["name"]
        if name not in STATIC:
            raise HTTPException(NOT_THERE)
        content = files(PACKAGE).joinpath("static", name).read_bytes()
        return Response(content, media_type=STATIC[name])

    async def report(self, request: Request) -> Response:
        """Return the page that contains the data set's report."""
        if not (await run_in_threadpool(self.state.now)).seen:
            raise HTTPException(NOT_THERE)
        more = {"source": "/data/report.html"}
        return await run_in_threadpool(self._page, request, "data", "report.html", more)

    async def report_file(self, _: Request) -> Response:
        """Return the data set's report, unless the operator must remain blind."""
        found = await run_in_threadpool(self.state.now)
        return _result(found.defaults.data, "report.html") if found.seen else _result(None, "")

    async def figure(self, _: Request) -> Response:
        """Return Fig. 15 as SVG unless the operator must remain blind."""
        found = await run_in_threadpool(self.state.now)
        return _result(found.defaults.data, "fig15.svg") if found.seen else _result(None, "")

    async def numbered_report(self, request: Request) -> Response:
        """Return the page with the report of a pilot, the rehearsals or an own table."""
        kind, number = request.path_params["kind"], request.path_params["number"]
        if self._numbered(request) is None:
            raise HTTPException(NOT_THERE)
        more = {"source": f"/{kind}/{number}/report.html"}
        return await run_in_threadpool(self._page, request, kind, "report.html", more)

    async def numbered_report_file(self, request: Request) -> Response:
        """Return the report of a pilot, the rehearsals or a laboratory's own table."""
        return _result(self._numbered(request), "report.html")

    def _numbered(self, request: Request) -> Path | None:
        """Return the folder of the requested pilot or table; None if there is none."""
        defaults = self.state.now().defaults
        folders = {
            "pilot": [*pilots(defaults), defaults.out(pilot=True)],
            "table": [] if self.access.read_only else tables(),
        }
        kind, number = request.path_params["kind"], request.path_params["number"]
        return next((path for path in folders.get(kind, []) if path.name == number), None)

    async def download(self, _: Request) -> Response:
        """Return the data set as a zip file, without temporary files."""
        if self.access.read_only:
            raise HTTPException(NOT_THERE)
        found = await run_in_threadpool(self.state.now)
        return await run_in_threadpool(_zip, found.defaults.data, "data-set.zip")

    async def plan(self, request: Request) -> Response:
        """Return one of the frozen plans in the folder."""
        name = request.path_params["name"]
        for path in () if self.access.read_only else await run_in_threadpool(frozen_plans):
            if path.name == name:
                return Response(path.read_bytes(), media_type="application/zip")
        raise HTTPException(NOT_THERE)

    async def export(self, _: Request) -> Response:
        """Return the last export as a zip file, if results may be seen."""
        found = await run_in_threadpool(self.state.now)
        if self.access.read_only or not found.seen:
            raise HTTPException(NOT_THERE)
        return await run_in_threadpool(_zip, export_folder(found.defaults.data), "export.zip")

    # Actions ------------------------------------------------------------------------------------

    async def do(self, request: Request) -> Response:
        """Carry out an action that a page requests; return its result."""
        sent, action = await request.body(), request.path_params["action"]

        def done(view: View) -> dict[str, Any]:
            before = [self.jobs.last(kind) for kind in KINDS]
            said = view.t.say(do(self.desk, action, sent))
            after = zip(KINDS, before, strict=True)
            started = [kind for kind, job in after if self.jobs.last(kind) is not job]
            return {"said": said, "started": started}

        return await self._answer(request, done)

    def _under_way(self, *, live: bool) -> list[str]:
        """Return the kinds of jobs that run; a session that pages show is no longer starting."""
        running = [kind for kind in KINDS if (job := self.jobs.last(kind)) and job.running]
        return [kind for kind in running if not (live and kind == "session")]


def make_app(access: Access, jobs: Jobs) -> tuple[Starlette, Console]:
    """Return the application and its console.

    Parameters
    ----------
    access : Access
        The console's address, and the users who may open it.
    jobs : Jobs
        Starts processes in the laboratory folder, which is the current working directory.
    """
    console = Console(access, jobs)

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        if console.presence:
            console.presence.announce()
        yield
        console.closing.set()
        if console.presence:
            console.presence.close()

    paths = {name: "/" if name == "today" else f"/{name}" for name in PAGES}
    routes = [
        *(Route(path, _page_of(console, name)) for name, path in paths.items()),
        Route("/events", console.events),
        Route("/static/{name}", console.static),
        Route("/data/report", console.report),
        Route("/data/report.html", console.report_file),
        Route("/data/fig15.svg", console.figure),
        Route("/data/download", console.download),
        Route("/data/export", console.export),
        Route("/planning/{name}", console.plan),
        Route("/{kind}/{number}/report", console.numbered_report),
        Route("/{kind}/{number}/report.html", console.numbered_report_file),
        Route("/study/edit", console.edit, methods=["POST"]),
        Route("/study/later", console.later, methods=["POST"]),
        Route("/do/{action}", console.do, methods=["POST"]),
    ]
    app = Starlette(
        routes=routes,
        middleware=[Middleware(Guard, access=access)],
        exception_handlers={NOT_THERE: console.missing},
        lifespan=lifespan,
    )
    return app, console


def _page_of(console: Console, name: str) -> Any:
    return partial(console.page, name=name)


def _result(dataset: Path | None, name: str) -> Response:
    """Return a file with results of a data set; 404 if the file does not exist."""
    kinds = {"report.html": "text/html", "fig15.svg": "image/svg+xml"}
    try:
        content = (dataset / RESULTS / name).read_bytes() if dataset else None
    except OSError:
        content = None
    if content is None:
        raise HTTPException(NOT_THERE)
    headers = {"content-security-policy": REPORT_POLICY}
    return Response(content, media_type=kinds[name], headers=headers)


def _zip(folder: Path, name: str) -> Response:
    """Return a folder as a zip file; 404 if the folder does not exist."""
    if not folder.is_dir():
        raise HTTPException(NOT_THERE)
    content = zipped(folder)
    headers = {"content-disposition": f'attachment; filename="{name}"'}
    return Response(content, media_type="application/zip", headers=headers)


def zipped(dataset: Path) -> bytes:
    """Return a data set as a zip file, without lock files, session messages and hidden files."""
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in _files(dataset):
            archive.write(path, path.relative_to(dataset.parent))
    return content.getvalue()


def _files(dataset: Path) -> Iterator[Path]:
    for path in sorted(dataset.rglob("*")):
        parts = path.relative_to(dataset).parts
        passing = any(part.endswith((".live", ".lock")) or part.startswith(".") for part in parts)
        if path.is_file() and not path.is_symlink() and not passing:
            yield path
