"""Requests to a service, by urllib."""

from __future__ import annotations

import functools
import http.client
import ipaddress
import json
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Mapping
from typing import Any, NamedTuple, Optional

from meshgauge.errors import InputError, ServiceError


class Answer(NamedTuple):
    status: int
    headers: Mapping[str, str]  # by their names in lower case
    body: bytes

    def json(self) -> dict[str, Any]:
        """The document of a success. Raises ServiceError when it is none, as from something else at this address."""
        document = self.problem()
        if not document:
            raise ServiceError("the answer is not that of a meshgauge service", self.status)
        return document

    def problem(self) -> dict[str, Any]:
        """The document, or {} when there is none."""
        try:
            document = json.loads(self.body)
        except (ValueError, RecursionError):
            return {}
        return document if isinstance(document, dict) else {}

    @property
    def retry_after(self) -> Optional[float]:
        value = self.headers.get("retry-after", "")
        return float(value) if value.isascii() and value.isdigit() else None


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """A redirection is an answer: following it would send the key to another host."""

    def redirect_request(self, *_: Any) -> None:
        return None


def _lower(headers: Any) -> dict[str, str]:
    return {name.lower(): value for name, value in headers.items()}


def _is_loopback(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class Http:
    """Sends single requests to one service."""

    def __init__(self, url: str, key: str, key_in_clear: bool, timeout: float) -> None:
        parts = urllib.parse.urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise InputError(f"url must be http://HOST or https://HOST, not {url!r}")
        if parts.username is not None or parts.password is not None:
            raise InputError("url must not have a user or a password: give a key")
        if key and not (key.isascii() and key.isprintable() and " " not in key):
            raise InputError("key must be visible ASCII")
        if key and not key_in_clear and parts.scheme == "http" and not _is_loopback(parts.hostname):
            raise InputError(f"key would be readable on its way to {parts.hostname}: use https, or key_in_clear=True")
        self._base = f"{parts.scheme}://{parts.netloc}{parts.path.rstrip('/')}"
        self._headers = {"Authorization": "Bearer " + key} if key else {}
        self._timeout = timeout

    @functools.cached_property
    def _opener(self) -> urllib.request.OpenerDirector:
        return urllib.request.build_opener(_NoRedirect)

    def once(self, method: str, path: str, pieces: list[bytes], headers: Mapping[str, str]) -> Answer:
        """Sends one request. Raises ServiceError without a status when there is no answer."""
        sent = {**self._headers, **headers, "Content-Length": str(sum(map(len, pieces)))}
        request = urllib.request.Request(self._base + path, pieces or None, sent, method=method)
        try:
            with self._opener.open(request, timeout=self._timeout) as answer:
                return Answer(answer.status, _lower(answer.headers), answer.read())
        except urllib.error.HTTPError as refusal:
            with refusal:
                return Answer(refusal.code, _lower(refusal.headers), refusal.read())
        except (OSError, http.client.HTTPException) as trouble:
            reason = getattr(trouble, "reason", None) or trouble
            raise ServiceError(f"{self._base} cannot be reached: {reason}") from trouble
