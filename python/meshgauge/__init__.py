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
            max_share_beyond: Optional[Mapping[str, Any]] = None,
            zone: Optional[Sequence[_options.Length]] = None,
            uncertainty: Optional[_options.Length] = None,
            narrow: Optional[bool] = None,
            regions: Optional[Iterable[Mapping[str, Any]]] = None,
            direction: Optional[str] = None,
            align: Any = None,
            timeout: Optional[Union[float, str]] = 30.0,
            strategy: Optional[str] = None,
            points: Optional[int] = None,
            tolerance: Optional[_options.Tolerance] = None,
            threads: Optional[int] = None,
            areas: Optional[Mapping[str, Any]] = None,
            sides: Optional[Union[bool, Mapping[str, float]]] = None,
            statistics: Optional[Union[bool, Mapping[str, int]]] = None,
            topology: Optional[bool] = None,
            expect: Optional[Mapping[str, Any]] = None,
            units: Optional[_options.Units] = None,
            vertex_distances: bool = False) -> Result:
    """Measures how far two meshes are apart, in this process.

    A mesh is a path (OBJ, STL, PLY, OFF, glTF, GLB, 3MF, XYZ; also gzip-compressed), the content of such a file as bytes, a
    pair (vertices, faces) of arrays of the shapes (n, 3) and (m, 3), an object of trimesh, Open3D, PyVista, meshio,
    numpy-stl or manifold3d (docs/python.md), or a list of such pairs and objects, which is one surface. Arrays of float64,
    and of uint32 or int32, that are contiguous are copied once, by the engine; what another thread changes meanwhile is
    measured in part. Without faces it is a point cloud, from which alone distances are measured: direction="a_to_b".

    Args:
        max_distance: The largest distance that passes, as a length or as a share ('0.5 %') of the diagonal of b: "0.05
            mm".
        max_share_beyond: The largest share of the area that may be farther than a distance: {"distance": "0.05 mm",
            "share": "1 %"}.
        zone: How far a may be inside and outside of b, which must be closed: ["-0.05 mm", "0.1 mm"].
        uncertainty: The uncertainty of the distances, by more than which they pass and fail (docs/metrology.md): "0.01
            mm". Default: 0.
        narrow: Once the verdict is known, measure on for a while, to say by how much it passes or fails. Default: True.
        regions: Boxes, spheres and groups of b that are measured by themselves, some with a limit (docs/regions.md):
            [{"name": "bore", "box": {"min": [0, 0, 0], "max": [9, 9, 9]}, "max_distance": "0.02 mm"}].
        direction: From which mesh the distance is measured; symmetric is the larger of both: "symmetric",
            "candidate_to_baseline", "baseline_to_candidate", "a_to_b", "b_to_a". Default: "symmetric".
        align: How a is moved before it is measured, by the best fit or by a transform (docs/alignment.md): "rigid".
            Default: "none".
        timeout: The time after which the work ends, in seconds or with a unit (ms, s, min): "60 s". Default: "30 s".
        strategy: How the distance is bounded; auto is the fastest, the others are for comparing methods: "auto",
            "four_point", "n_point", "triangle_set". Default: "auto".
        points: Samples a piece, for the strategy n_point: 4, 10, 31, 109, 409, 1585. Default: 4.
        tolerance: How narrow the interval has to be; the first of these rules that holds ends the work: {"relative":
            0.001}. Default: {"diagonal": 1e-06, "relative": 0.01}.
        threads: At most so many threads, 1 to 64.
        areas: Certify how the distance is distributed over the area (docs/statistics.md): {"beyond": [0.05, 0.1],
            "quantiles": [0.95, 0.99], "mean": True}.
        sides: Certify how far a reaches outside and inside of b, which must be closed: True. Default: False.
        statistics: Sample mean, RMS, percentiles and a histogram as well (docs/statistics.md): {"samples": 200000,
            "seed": 7}. Default: False.
        topology: Also examine both meshes: open edges, orientation, components, volume. Default: False.
        expect: What a itself has to be like (docs/check.md): {"watertight": True, "triangles": {"max": 20000}}.
        units: The unit of both meshes, or of each, whatever their files say (docs/units.md): "mm".
        vertex_distances: True also measures the distance at each vertex of a (Result.vertex_distances, an array of
            numpy) and, with sides or a zone, the signed one (Result.signed_vertex_distances); within the timeout once more.

    Python's own forms: a number as the tolerance is the width of the interval, in the unit of the result; units may be a
    pair of those of a and b, None where the file says it; a transform may be a 4x4 matrix, and stand for all of align;
    timeout=None is no limit. With a limit the default of the tolerance is {"diagonal": 1e-9}, so that the work ends with
    a verdict. Without threads there is one for each processor. With one thread, the same input gives the same bits; with
    more, the interval may differ within the tolerance, the verdict never.

    What is asked for beside the interval is in Result.regions and in Result.document: "share_beyond", "sides", "areas",
    "statistics", "alignment", "expectations", and "topology" of each of its "meshes".

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
