"""A client of a meshgauge service, by the standard library alone."""

from __future__ import annotations

import hashlib
import json
import os
import random
import time
import urllib.parse
import uuid
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Optional, Union

from meshgauge import _meshes, _options
from meshgauge._http import Answer, Http
from meshgauge.errors import InputError, ServiceError, input_error, kind_of
from meshgauge.result import Result

_RETRIED = (429, 502, 503, 504)
_FIRST_PAUSE_S, _LAST_PAUSE_S = 0.05, 2.0
_ENDED = ("done", "failed", "cancelled")
_MAPS = ("ply", "glb", "vtp", "csv")


class Client:
    """Measures at a service; results, options and errors are those of meshgauge.compare(). timeout=None is the
    service's default, not 7 days.

    Args:
        url: address of the service, "https://meshgauge.example".
        key: its key; default: the variable MESHGAUGE_KEY.
        key_in_clear: True allows to send the key by http to another machine.
        retry_time: for so many seconds a request is repeated while the service cannot be reached or has no room.
        request_timeout: seconds without any byte from the service after which a request has failed.

    May be used by any number of threads.
    """

    def __init__(self, url: str, key: Optional[str] = None, *, key_in_clear: bool = False,
                 retry_time: float = 60.0, request_timeout: float = 300.0) -> None:
        key = os.environ.get("MESHGAUGE_KEY", "") if key is None else key
        self._http = Http(url, key, key_in_clear, request_timeout)
        self._retry_time = retry_time

    def compare(self, a: Any, b: Any, max_distance: Optional[_options.Length] = None, **options: Any) -> Result:
        """Sends both meshes and waits for the result. Ctrl-C cancels.

        Raises what meshgauge.compare() raises, and ServiceError when the service cannot be reached or refuses.
        """
        answer, notes = self._compare(a, b, max_distance, options, {})
        return Result(_meshes.noted(answer.json(), notes))

    def submit(self, a: Any, b: Any, max_distance: Optional[_options.Length] = None, **options: Any) -> Job:
        """Sends both meshes and returns at once. The comparison goes on when this process ends."""
        headers = {"Prefer": "respond-async", "Idempotency-Key": uuid.uuid4().hex}
        answer, notes = self._compare(a, b, max_distance, options, headers)
        return Job(self, answer.json()["id"], notes)

    def job(self, id: str) -> Job:
        """A comparison that was submitted before, by its id. What was noted when its objects were read is not known any more."""
        return Job(self, id)

    def batch(self, pairs: Iterable[Any], max_distance: Optional[_options.Length] = None, *,
              name: Optional[str] = None, **options: Any) -> list[Union[Result, Exception]]:
        """Compares many pairs, (a, b) or (a, b, options of this pair), and waits for all. Each mesh is sent once.

        Returns a Result for each pair, in their order, or the exception that compare() would have raised for it.
        Ctrl-C cancels the batch.
        """
        stored: dict[str, bool] = {}
        all_notes: list[_meshes.Notes] = []
        comparisons = [self._stored_pair(pair, stored, all_notes) for pair in pairs]
        if not comparisons:
            return []
        manifest = {"options": _sent(max_distance, options), "comparisons": comparisons}
        if name is not None:
            manifest["name"] = name
        path = "/v1/batches/" + self.ask("POST", "/v1/batches", [json.dumps(manifest).encode()],
                                         {"Content-Type": "application/json", "Idempotency-Key": uuid.uuid4().hex}).json()["id"]
        try:
            _until(lambda: self.ask("GET", path).json()["state"] in _ENDED, None)
        except BaseException:
            self._http.once("DELETE", path, [], {})
            raise
        lines = self.ask("GET", path + "/results.jsonl").body.splitlines()
        found = {line["position"]: line for line in map(json.loads, lines)}
        return [_outcome(found[position], notes) for position, notes in enumerate(all_notes)]

    def map(self, comparison: Union[Result, str], format: str = "ply", *, of: str = "a", normals: bool = False,
            max_triangles: Optional[int] = None, meshes: Optional[tuple[Any, Any]] = None) -> bytes:
        """The file of a mesh with its distance from the other one at each vertex (docs/deviation.md of the project).

        Args:
            comparison: what compare() or batch() returned, or the id of a comparison that has ended.
            format: "ply", "glb", "vtp" or "csv".
            of: the mesh that is shown, "a" or "b".
            normals: True adds the normal of each vertex.
            max_triangles: of a GLB alone.
            meshes: a and b of the comparison, which are sent again where the service has not kept them.

        Raises ServiceError: 410, when it has not and there are no `meshes`.
        """
        if format not in _MAPS:
            raise InputError(f"format must be one of {', '.join(_MAPS)}, not {format!r}")
        id = comparison if isinstance(comparison, str) else comparison.document["id"]
        query: dict[str, Any] = {"of": of, **({"normals": "true"} if normals else {}),
                                 **({} if max_triangles is None else {"max_triangles": max_triangles})}
        path = f"{_path_of(id)}/deviation.{format}?{urllib.parse.urlencode(query)}"
        try:
            return self.ask("GET", path).body
        except ServiceError as gone:
            if gone.status != 410 or meshes is None:
                raise
        stored: dict[str, bool] = {}
        for mesh, part in zip(meshes, "ab"):
            self._store(_meshes.source_of(mesh, part), part, stored)
        return self.ask("GET", path).body

    def ask(self, method: str, path: str, body: Iterable[bytes] = (), headers: Optional[Mapping[str, str]] = None) -> Answer:
        """Sends a request, again after passing failures. Raises for an answer that is no success."""
        pieces, end, pause = list(body), time.monotonic() + self._retry_time, _FIRST_PAUSE_S
        while True:
            try:
                answer = self._http.once(method, path, pieces, headers or {})
                if answer.status < 400:
                    return answer
                failure = _exception(answer)
            except ServiceError as unreachable:
                failure = unreachable
            pause_s = max(pause * random.uniform(0.5, 1.0), getattr(failure, "retry_after", None) or 0.0)
            status = getattr(failure, "status", 0)
            if (status is not None and status not in _RETRIED) or time.monotonic() + pause_s > end:
                raise failure
            time.sleep(pause_s)
            pause = min(2 * pause, _LAST_PAUSE_S)

    def _compare(self, a: Any, b: Any, max_distance: Optional[_options.Length], options: Mapping[str, Any],
                 headers: Mapping[str, str]) -> tuple[Answer, _meshes.Notes]:
        sources = _meshes.source_of(a, "a"), _meshes.source_of(b, "b")
        options = dict(options)
        options.setdefault("units", _meshes.units_of(*sources))
        form = _Form()
        for name, source in zip("ab", sources):
            upload = _upload(source, name)
            form.add(name, upload.content, upload.file_name)
        form.add("options", json.dumps(_sent(max_distance, options)).encode())
        answer = self.ask("POST", "/v1/comparisons", form.end(), {**headers, "Content-Type": form.content_type})
        return answer, _meshes.notes_of(*sources)

    def _stored_pair(self, pair: Any, stored: dict[str, bool], all_notes: list[_meshes.Notes]) -> dict[str, Any]:
        a, b, *more = pair
        sources = _meshes.source_of(a, "a"), _meshes.source_of(b, "b")
        options = dict(more[0]) if more else {}
        options.setdefault("units", _meshes.units_of(*sources))
        all_notes.append(_meshes.notes_of(*sources))
        return {"a": self._store(sources[0], "a", stored), "b": self._store(sources[1], "b", stored),
                "options": _sent(options.pop("max_distance", None), options)}

    def _store(self, mesh: _meshes.Source, part: str, stored: dict[str, bool]) -> str:
        """Stores a mesh unless `stored` has it, and returns its id."""
        upload = _upload(mesh, part)
        id = hashlib.sha256(upload.content).hexdigest()
        if id not in stored:
            self.ask("PUT", "/v1/meshes/" + id, [upload.content],
                     {"Content-Type": "application/octet-stream",
                      "Content-Disposition": f"attachment; filename={_quoted(upload.file_name)}"})
            stored[id] = True
        return id


class Job:
    """A comparison at a service."""

    def __init__(self, client: Client, id: str, notes: Optional[_meshes.Notes] = None) -> None:
        self._client = client
        self._notes = notes or {}
        self.id = id

    @property
    def _path(self) -> str:
        return _path_of(self.id)

    def state(self) -> dict[str, Any]:
        """The current state with the interval so far (openapi.yaml, Job)."""
        return self._client.ask("GET", self._path).json()

    def wait(self, timeout: Optional[float] = None) -> Result:
        """Waits for the result. Raises TimeoutError after `timeout` seconds; the comparison goes on."""
        job: dict[str, Any] = {}

        def ended() -> bool:
            job.update(self.state())
            return job["state"] in _ENDED

        _until(ended, timeout)
        outcome = _outcome(job, self._notes)
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    def cancel(self) -> None:
        """Cancels the comparison; if it has ended, deletes its result."""
        self._client.ask("DELETE", self._path)


def _path_of(id: str) -> str:
    return "/v1/comparisons/" + urllib.parse.quote(id, safe="")


class _Upload(NamedTuple):
    content: bytes
    file_name: str


class _Form:
    """A body of multipart/form-data, as pieces."""

    def __init__(self) -> None:
        self._boundary = "meshgauge-" + uuid.uuid4().hex
        self._pieces: list[bytes] = []
        self.content_type = "multipart/form-data; boundary=" + self._boundary

    def add(self, name: str, content: bytes, file_name: str = "") -> None:
        file = f"; filename={_quoted(file_name)}" if file_name else ""
        head = f'--{self._boundary}\r\nContent-Disposition: form-data; name="{name}"{file}\r\n\r\n'
        self._pieces += [head.encode(), content, b"\r\n"]

    def end(self) -> list[bytes]:
        return [*self._pieces, f"--{self._boundary}--\r\n".encode()]


def _quoted(file_name: str) -> str:
    """A file name as a quoted string of printable ASCII: it is a hint for the format, and a name on the page."""
    return '"' + "".join(c if " " <= c <= "~" and c not in '"\\' else "_" for c in file_name) + '"'


def _upload(source: _meshes.Source, part: str) -> _Upload:
    content = source.to_file()
    if not isinstance(source, _meshes.File):
        return _Upload(content, "" if isinstance(source, _meshes.Content) else part + ".ply")
    file_name = os.path.basename(os.fsdecode(source.path))
    if file_name.lower().endswith(".gltf") and _meshes.names_files(content):
        raise InputError(f"'{part}' is a glTF of several files: send a .glb, or a .zip of the .gltf and its files")
    return _Upload(content, file_name)


def _sent(max_distance: Optional[_options.Length], options: Mapping[str, Any]) -> dict[str, Any]:
    return _options.document(max_distance=max_distance, **options)


def _until(ended: Any, timeout: Optional[float]) -> None:
    """Asks until `ended` says so, less often as time passes."""
    end = None if timeout is None else time.monotonic() + timeout
    pause = _FIRST_PAUSE_S
    while not ended():
        if end is not None and time.monotonic() + pause > end:
            raise TimeoutError("the comparison has not ended yet")
        time.sleep(pause)
        pause = min(1.5 * pause, _LAST_PAUSE_S)


def _outcome(ended: Mapping[str, Any], notes: _meshes.Notes) -> Union[Result, Exception]:
    """The result of a job, or of a line of a batch."""
    if ended["result"] is not None:
        return Result(_meshes.noted(ended["result"], notes))
    problem = ended["problem"] or {"detail": "the result is no longer stored"}
    return input_error(problem) or ServiceError(problem["detail"], problem.get("status"), kind_of(problem))


def _exception(answer: Answer) -> Exception:
    problem = answer.problem()
    detail = problem.get("detail") or f"the service answers with HTTP status {answer.status}"
    return input_error(problem) or ServiceError(detail, answer.status, kind_of(problem), answer.retry_after)
