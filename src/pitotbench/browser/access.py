"""Who may use the page: its starter, from this computer, through the address that was printed."""

import hmac
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any

from bokeh.server.tornado import BokehTornado
from bokeh.server.views.doc_handler import DocHandler
from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.web import HTTPError, OutputTransform, RequestHandler, stream_request_body

_NEVER = ("/autoload.js", "/metadata", "/favicon.ico")  # Bokeh's, for pages of other hosts
_CLOSED = "open the address that pitotbench printed"
_HEADERS = {
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_POLICY = (  # of the page; scripts are those of this server and those that bear the page's number
    "default-src 'none'; script-src 'self' 'nonce-{nonce}'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self' ws://{host}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


@dataclass(frozen=True, slots=True)
class Access:
    """How a browser proves that it may use the page: port, `token` in its address, then a cookie.

    The cookie holds the `secret`.
    """

    port: int
    token: str
    secret: str

    @property
    def hosts(self) -> tuple[str, ...]:
        """The names under which the page is reached."""
        return f"127.0.0.1:{self.port}", f"localhost:{self.port}"

    @property
    def address(self) -> str:
        """The address to open."""
        return f"http://{self.hosts[0]}/?token={self.token}"

    @property
    def cookie(self) -> str:
        """The name of the cookie: cookies are shared by all ports of a host."""
        return f"pitotbench-{self.port}"

    def refusal(self, request: HTTPServerRequest) -> str:
        """Return why a request is refused, before its body is read; empty where it is not."""
        if request.headers.get("Host", "") not in self.hosts:
            return "this page is on 127.0.0.1 alone"
        if request.headers.get("Origin") not in (None, *(f"http://{host}" for host in self.hosts)):
            return "this page takes nothing from another page"
        secret = request.cookies.get(self.cookie)
        if secret is None or not hmac.compare_digest(secret.value.encode(), self.secret.encode()):
            return _CLOSED
        return ""


@stream_request_body
class Refused(RequestHandler):
    """Refuses a request before its body is read."""

    def initialize(self, refusal: HTTPError) -> None:
        self.refusal = refusal

    def prepare(self) -> None:
        raise self.refusal


class Entrance(RequestHandler):
    """Takes the secret out of the address and puts it into a cookie."""

    def get(self) -> None:
        access: Access = self.settings["access"]
        self.set_cookie(
            access.cookie,
            access.secret,
            httponly=True,
            samesite="Strict",
            path="/",
            expires_days=None,
        )
        self.redirect("/")


class Page(DocHandler):  # type: ignore[misc]
    """Bokeh's page, whose scripts bear a number that no other script knows."""

    async def get(self, *_: object, **__: object) -> None:
        from secrets import token_urlsafe

        from bokeh.embed.server import server_html_page_for_session

        session, nonce = await self.get_session(), token_urlsafe()
        document = session.document
        page = server_html_page_for_session(
            session,
            resources=self.application.resources(),
            title=document.title,
            template=document.template,
            template_variables=document.template_variables,
        )
        policy = _POLICY.format(nonce=nonce, host=self.request.headers["Host"])
        self.set_header("Content-Security-Policy", policy)
        self.finish(page.replace("<script", f'<script nonce="{nonce}"'))


class _Headers(OutputTransform):
    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        headers.update(_HEADERS)
        headers.setdefault("Content-Security-Policy", "default-src 'none'")
        return status_code, headers, chunk


class Guarded(BokehTornado):  # type: ignore[misc]
    """Bokeh's application behind one gate, which every request passes, also a websocket's."""

    def __init__(self, applications: Any, access: Access, **settings: Any) -> None:
        super().__init__(
            applications,
            extra_websocket_origins=list(access.hosts),
            use_index=False,
            access=access,
            log_function=lambda handler: None,  # a stranger's path has no place on the terminal
            **settings,
        )
        context = {"application_context": self._applications["/"], "bokeh_websocket_path": "/ws"}
        self.add_handlers(".*", [("/", Page, context)])
        self.add_transform(_Headers)

    def find_handler(self, request: HTTPServerRequest, **_: Any) -> Any:
        """Return what answers a request: the gate's refusal, the entrance, or the handler."""
        access = self.settings["access"]
        token = request.query_arguments.get("token", [b""])[0]
        words = access.refusal(request)
        # In a time that does not depend on the token.
        known = hmac.compare_digest(token, access.token.encode())
        if request.path == "/" and known and words in ("", _CLOSED):
            return self.get_handler_delegate(request, Entrance)
        if words or request.path in _NEVER:
            status = HTTPStatus.FORBIDDEN if words else HTTPStatus.NOT_FOUND
            arguments = {"refusal": HTTPError(status, reason=words or "not here")}
            return self.get_handler_delegate(request, Refused, arguments)
        return super().find_handler(request)
