"""How far apart are two triangle meshes? Certified intervals of the Hausdorff distance.

    import meshgauge
    result = meshgauge.compare("part.stl", (vertices, faces), max_distance="0.05 mm")
    print(result.verdict, result.lower, result.upper, result.witness)

docs/python.md of the project has the whole story.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

from meshgauge import _meshes, _native, _options
from meshgauge.errors import InputError, ServiceError
from meshgauge.result import Directed, Result, Witness

if TYPE_CHECKING:
    from meshgauge.client import Client

__all__ = ["Client", "Directed", "InputError", "Result", "ServiceError", "Witness", "compare"]


def compare(a: Any, b: Any, max_distance: Optional[_options.Length] = None, *,
            tolerance: Optional[_options.Tolerance] = None, timeout: Union[float, str, None] = 30.0,
            threads: Optional[int] = None, direction: Optional[str] = None,
            units: Optional[_options.Units] = None, strategy: Optional[str] = None, points: Optional[int] = None,
            statistics: Union[bool, Mapping[str, int], None] = None,
            areas: Optional[Mapping[str, Any]] = None, topology: Optional[bool] = None,
            max_share_beyond: Optional[Mapping[str, Any]] = None,
            zone: Optional[Sequence[_options.Length]] = None,
            sides: Union[bool, Mapping[str, float], None] = None,
            uncertainty: Optional[_options.Length] = None, narrow: Optional[bool] = None,
            regions: Optional[Iterable[Mapping[str, Any]]] = None, align: Any = None,
            expect: Optional[Mapping[str, Any]] = None,
            vertex_distances: bool = False) -> Result:
    """Measures how far two meshes are apart, in this process.

    A mesh is a path (OBJ, STL, PLY, OFF, glTF, GLB, 3MF, XYZ; also gzip-compressed), the content of such a file as bytes, a
    pair (vertices, faces) of arrays of the shapes (n, 3) and (m, 3), an object of trimesh, Open3D, PyVista, meshio,
    numpy-stl or manifold3d (docs/python.md), or a list of such pairs and objects, which is one surface. Arrays of float64,
    and of uint32 or int32, that are contiguous are copied once, by the engine; what another thread changes meanwhile is
    measured in part. Without faces it is a point cloud, from which alone distances are measured: direction="a_to_b".

    Args:
        max_distance: the limit, as a number in the unit of the result or as text, "0.05 mm", or "0.5 %" of the diagonal of b. With it, the work ends
            as soon as the verdict is known.
        tolerance: how narrow the interval shall be. A number: its width in the unit of the result. Else a mapping
            with "absolute", "diagonal" (share of the diagonal of a) or "relative" (share of `lower`), of which the
            first that holds ends the work. Default: {"diagonal": 1e-6, "relative": 0.01}; with a limit,
            {"diagonal": 1e-9}.
        timeout: seconds, or "500 ms", after which the work ends, with the interval reached so far. None: no limit.
        threads: at most so many threads, 1 to 64. Default: one for each processor. With one thread, the same input
            gives the same bits; with more, the interval may differ within the tolerance, the verdict never.
        direction: "symmetric" (default), "a_to_b" or "b_to_a".
        units: unit of both meshes, or a pair with that of a and that of b: "um", "mm", "cm", "m", "in", "ft", or None
            where the file says it. Default: what the file or the object names.
        strategy, points: another algorithm: "auto" (default), "four_point", "n_point" with `points`, "triangle_set".
        statistics: True also samples mean, RMS and percentiles (Result.document["statistics"]); a mapping may set
            "samples" and "seed".
        areas: certifies how the distance is distributed over the area (Result.document["areas"]); a mapping with
            "beyond" (distances), "quantiles" (shares), "mean" (True), "share_tolerance" and "length_tolerance".
        topology: True also examines both meshes: open edges, orientation, components and the certified volume
            (Result.document["meshes"]["a"]["topology"]).
        max_share_beyond: {"distance": "0.05 mm", "share": 0.01}: a limit, beside max_distance or alone: at most one
            percent of the area may be farther than that (Result.document["share_beyond"]).
        regions: parts that are measured each by itself (Result.regions): {"name": "bore", "box": {"min": [0, 0, 0],
            "max": [10, 10, 25]}, "max_distance": "0.02 mm"}, or with "sphere": {"centre": [0, 0, 40], "radius": 5} or
            "group": "Lid", a group of b's file; coordinates in the unit of the result. max_distance is then the limit of the rest.
        zone: ("-0.05 mm", "0.1 mm"): limits of how far a is inside and outside of b, a closed mesh, beside other limits
            or alone (Result.document["sides"]).
        sides: True also certifies how far a reaches outside and inside of b (Result.document["sides"]); a mapping may
            set "length_tolerance".
        uncertainty: of the distances, as the limit: the verdict is "pass" or "fail" only by more than this.
        narrow: False: the work ends with the verdict. Else it goes on for at most half a second, to say by how much the limit
            is kept or exceeded: until the interval is one percent of the distance wide.
        align: moves a before it is measured (Result.document["alignment"]). "rigid": by the best fit; a 4x4 matrix: by
            that transform; a mapping with "transform", "fit", "principal_axes", "overlap", as the service has it.
        expect: what a itself has to be like (Result.document["expectations"]): {"watertight": True, "triangles": {"max":
            20000}, "degenerate": 0, "components": 1, "volume": {"within": 0.01}}, a share of b's volume. It counts in
            the verdict, beside limits or alone, and is in the result as "expect".
        vertex_distances: True also measures the distance at each vertex of a (Result.vertex_distances, an array of
            numpy) and, with sides or a zone, the signed one (Result.signed_vertex_distances); within the timeout once more.

    Ctrl-C cancels. Other Python threads run meanwhile. May be called from any number of threads.

    Raises:
        InputError (a ValueError): a mesh or an option is refused; the message names the defect.
        OSError: a path has no file.
        TimeoutError: the time was over before both meshes were read, or all vertices measured.
        MemoryError: there is no memory for a copy that is needed.
    """
    # First, while the arguments are the only locals.
    options = {name: value for name, value in locals().items() if name not in ("a", "b", "vertex_distances")}
    sources = _meshes.source_of(a, "a"), _meshes.source_of(b, "b")
    if units is None:
        options["units"] = _meshes.units_of(*sources)
    sent = _options.document(**options)
    document, *distances = _native.measure(sources[0].to_native(), sources[1].to_native(), sent, vertex_distances)
    return Result(_meshes.noted(document, _meshes.notes_of(*sources)), *distances)


def __getattr__(name: str) -> Any:
    if name == "Client":  # its imports take longer than all others
        from meshgauge.client import Client

        return Client
    if name == "__version__":
        return _native.version()
    raise AttributeError(f"module 'meshgauge' has no attribute {name!r}")
