"""A small server on this machine's own address, for one person who looks at a page."""

from __future__ import annotations

import socket
import webbrowser
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from lumpedcable.page.controls import FaultError
from lumpedcable.results.errors import OutputError

if TYPE_CHECKING:
    from starlette.applications import Starlette

__all__ = ["application", "serve"]

HOST = "127.0.0.1"
Answer = Callable[[Any], Any]


def _needed() -> OutputError:
    return OutputError(
        'showing a page needs the extra "view": pip install "lumpedcable[view]"; '
        "-o page.html writes the page of a results file without it"
    )


def application(page: str, answers: Mapping[str, Answer] | None = None) -> Starlette:
    """An app that gives one page at / and answers JSON with JSON.

    Args:
        page: the HTML text.
        answers: by path, what makes the answer from the JSON value posted there; a FaultError becomes
            the answer {"fault": its message}. Any other error is raised, to be reported here.

    Raises:
        OutputError: the extra is not installed.
    """
    try:
        from starlette.applications import Starlette
        from starlette.concurrency import run_in_threadpool
        from starlette.middleware import Middleware
        from starlette.middleware.trustedhost import TrustedHostMiddleware
        from starlette.requests import Request
        from starlette.responses import HTMLResponse, JSONResponse, Response
        from starlette.routing import Route
    except ImportError:
        raise _needed() from None

    async def give_page(request: Request) -> Response:
        return HTMLResponse(page)

    def answering(answer: Answer) -> Callable[[Request], Any]:
        async def reply(request: Request) -> Response:
            try:
                asked = await request.json()
            except RecursionError:
                return JSONResponse({"fault": "expected plain JSON, found it too deep"}, 400)
            except ValueError as error:  # a fault of the page itself, told there
                return JSONResponse({"fault": str(error)})
            try:
                return JSONResponse(await run_in_threadpool(answer, asked))
            except FaultError as error:
                return JSONResponse({"fault": str(error)})

        return reply

    async def tell_failure(request: Request, error: Exception) -> Response:
        # it is raised again afterwards
        return JSONResponse({"fault": "an error in the program: its terminal tells where"}, 500)

    routes = [Route("/", give_page)]
    for path, answer in (answers or {}).items():
        routes.append(Route(path, answering(answer), methods=["POST"]))
    # no page of another site may speak to it under a name of its own
    guard = Middleware(TrustedHostMiddleware, allowed_hosts=[HOST, "localhost"])
    return Starlette(
        routes=routes, middleware=[guard], exception_handlers={Exception: tell_failure}
    )


def serve(app: Starlette, port: int, browser: bool, on_start: Callable[[str], None]) -> None:
    """Serve an app on 127.0.0.1 until it is interrupted.

    Raises:
        OutputError: the extra is not installed, or the port cannot be had.
    """
    try:
        import uvicorn
    except ImportError:
        raise _needed() from None
    if not 0 <= port <= 65535:
        raise OutputError(f"--port: expected a number from 0 to 65535, found {port}")
    # named as TCP, or asyncio leaves small answers waiting for the 40 ms of a late acknowledgement
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((HOST, port))
        except OSError as error:
            raise OutputError(f"--port: {port} cannot be had: {error.strerror}") from error
        # listening before the address is told: a browser that comes early waits
        listener.listen()
        url = f"http://{HOST}:{listener.getsockname()[1]}/"
        server = uvicorn.Server(uvicorn.Config(app, log_level="warning", lifespan="off"))
        on_start(url)
        if browser:
            webbrowser.open(url)
        with suppress(KeyboardInterrupt):  # the way to end it
            server.run(sockets=[listener])
