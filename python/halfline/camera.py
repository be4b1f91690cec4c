"""Perspective and orthographic cameras, and cameras of computer vision."""

from __future__ import annotations

import json
import math
import warnings
from os import PathLike
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike

from . import _halfline
from ._arrays import Spheres, native_scene, number, vector
from ._arrays import size as checked_size

LensName = Literal["fisheye", "equirectangular", "opencv"]

# Before the name of a lens in the native module.
_NAMED = "lens "


class Camera:
    """A camera: where the eye is, where it looks, and its lens.

    Args:
        eye: Position of the eye, in scene units.
        at: Point to look at.
        view: Direction to look in, of any length; instead of ``at``. The default is -z.
        up: Up direction of the scene, not necessarily of the image.
        vfov: Full vertical field of view in degrees, between 0 and 180; 30 without another lens. Of
            a fisheye at most 360; 180 by default.
        lens: A lens that is not one of a plane: ``"fisheye"`` (image heights grow with the angle;
            ``vfov`` is the angle of the full height), ``"equirectangular"`` (the whole sphere), or
            ``"opencv"`` (``intrinsics`` and ``lens_coefficients``).
        intrinsics: Focal lengths and principal point ``(fx, fy, cx, cy)`` of such a lens, in pixels
            of the picture; the centre of the top left pixel is (0.5, 0.5). `from_intrinsics` takes
            intrinsics for an image of a certain size.
        lens_coefficients: Distortion by the model of OpenCV, k1, k2, p1, p2, or with k3 or
            k3, k4, k5, k6 behind them; of a fisheye k1 to k4.
        viewport: Width and height of the viewport at ``distance``, in any unit; instead of
            ``vfov``.
        distance: Distance of the viewport from the eye, in the unit of ``viewport``.
        height: Height of the view in scene units: parallel rays (orthographic), which start at the
            plane of the eye.
        aperture: Diameter of the lens in scene units; what is not in focus is blurred. Pictures
            then have 64 ``samples`` unless more are given. The default is a pinhole.
        focus: Distance along the view of the plane in focus; by default the distance of ``at``.

    Raises:
        ValueError: for numbers that give no direction or no viewport, with the name of the
            argument.

    >>> import halfline as hl
    >>> hl.Camera((0, 0, 5), at=(0, 0, 0), vfov=45)
    Camera(eye=(0.0, 0.0, 5.0), at=(0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0), vfov=45.0)
    >>> hl.Camera((0, 0, 5), view=(0, 0, -1), height=3)
    Camera(eye=(0.0, 0.0, 5.0), view=(0.0, 0.0, -1.0), up=(0.0, 1.0, 0.0), height=3.0)
    >>> hl.Camera((0, 0, 5), at=(0, 0, 0), lens="fisheye", vfov=200)
    Camera(eye=(0.0, 0.0, 5.0), at=(0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0), lens='fisheye', vfov=200.0)
    """

    __slots__ = ("_native", "_words")

    _native: _halfline.Camera
    _words: str | None

    def __init__(
        self,
        eye: ArrayLike,
        *,
        at: ArrayLike | None = None,
        view: ArrayLike | None = None,
        up: ArrayLike = (0.0, 1.0, 0.0),
        vfov: float | None = None,
        lens: LensName | None = None,
        intrinsics: tuple[float, float, float, float] | None = None,
        lens_coefficients: ArrayLike | None = None,
        viewport: tuple[float, float] | None = None,
        distance: float = 1.0,
        height: float | None = None,
        aperture: float | None = None,
        focus: float | None = None,
    ) -> None:
        if at is not None and view is not None:
            raise ValueError("at and view exclude each other; give one of them")
        named = _named_lens(lens, vfov, intrinsics, lens_coefficients)
        first: dict[str, object] = {"vfov": vfov} if named is None else {"lens": lens}
        given = {**first, "viewport": viewport, "height": height}
        kinds = [name for name, value in given.items() if value is not None]
        if len(kinds) > 1:
            raise ValueError(f"{' and '.join(kinds)} exclude each other; give one of them")
        kind = kinds[0] if kinds else "vfov"
        lens_values: dict[str, Any] = {}
        if named is not None:
            kind, numbers, lens_values = named
        elif kind == "vfov":
            numbers = [
                number("vfov", 30.0 if vfov is None else vfov),
                number("distance", distance),
            ]
        elif kind == "height":
            numbers = [number("height", height)]
        else:
            numbers = [*_two("viewport", viewport), number("distance", distance)]
        look = (
            {"at": vector("at", at)}
            if at is not None
            else {"view": vector("view", (0, 0, -1) if view is None else view)}
        )
        eye, up = vector("eye", eye), vector("up", up)
        if aperture is None and focus is not None:
            raise ValueError("all is in focus without an aperture; give aperture, or remove focus")
        sizes = {"aperture": aperture, "focus": focus}
        opening = {name: number(name, value) for name, value in sizes.items() if value is not None}
        self._native = _halfline.Camera(
            eye,
            look.get("at"),
            look.get("view"),
            up,
            (kind, numbers),
            None,
            opening.get("aperture"),
            opening.get("focus"),
        )
        values: dict[str, Any] = {"eye": eye, **look, "up": up, **lens_values}
        if named is None:
            values[kind] = tuple(numbers[:2]) if kind == "viewport" else numbers[0]
        if kind in ("vfov", "viewport") and distance != 1.0:
            values["distance"] = numbers[-1]
        values.update(opening)
        self._words = ", ".join(f"{name}={value!r}" for name, value in values.items())

    @overload
    @classmethod
    def from_intrinsics(
        cls,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        width: int,
        height: int,
        pose: ArrayLike | None = None,
        *,
        pixel_center: float = 0.5,
        convention: Literal["opencv", "opengl"] = "opencv",
        distortion: ArrayLike | None = None,
        fisheye: bool = False,
    ) -> Camera: ...

    @overload
    @classmethod
    def from_intrinsics(
        cls,
        *,
        K: ArrayLike,  # noqa: N803
        width: int,
        height: int,
        pose: ArrayLike | None = None,
        pixel_center: float = 0.5,
        convention: Literal["opencv", "opengl"] = "opencv",
        distortion: ArrayLike | None = None,
        fisheye: bool = False,
    ) -> Camera: ...

    @classmethod
    def from_intrinsics(
        cls,
        fx: Any = None,
        fy: Any = None,
        cx: Any = None,
        cy: Any = None,
        width: Any = None,
        height: Any = None,
        pose: ArrayLike | None = None,
        *,
        K: ArrayLike | None = None,  # noqa: N803
        pixel_center: float = 0.5,
        convention: Literal["opencv", "opengl"] = "opencv",
        distortion: ArrayLike | None = None,
        fisheye: bool = False,
    ) -> Camera:
        """A camera of computer vision, for images of ``width`` x ``height`` pixels.

        Args:
            fx: Focal length across, in pixels.
            fy: Focal length down, in pixels.
            cx: Column of the principal point, which may lie anywhere, in pixels.
            cy: Row of the principal point, from the top, in pixels.
            width: Columns of the image.
            height: Rows of the image.
            K: The matrix (3, 3) of ``fx, 0, cx; 0, fy, cy; 0, 0, 1`` in place of the four numbers.
                A skew is refused, since pixels are rectangles here.
            pose: Matrix (4, 4) or (3, 4) from camera to world: its columns are the axes of
                ``convention`` and the eye. The axes are perpendicular, of length 1 and not
                mirrored, to 1 in 1000. The default is the identity.
            pixel_center: The centre of the top left pixel in the coordinates of ``cx`` and ``cy``:
                0.5 as in COLMAP and in the command's lists of cameras, 0 as in OpenCV's own
                functions.
            convention: The axes of ``pose``: ``"opencv"`` is right, down, forward, ``"opengl"`` is
                right, up, backward, as in pyrender, Blender and NeRF.
            distortion: Coefficients in the order of OpenCV: k1, k2, p1, p2, k3, k4, k5, k6; the
                last may be left out. A fisheye has k1 to k4.
            fisheye: Whether the lens is a fisheye of OpenCV's model.

        Raises:
            ValueError: for a matrix whose columns are no axes, with what was found.

        >>> import halfline as hl
        >>> hl.Camera.from_intrinsics(525, 525, 320, 240, 640, 480).size
        (640, 480)
        >>> hl.Camera.from_intrinsics(K=[[525, 0, 320], [0, 525, 240], [0, 0, 1]], width=640,
        ...     height=480).record()["intrinsics"]
        {'fx': 525.0, 'fy': 525.0, 'cx': 320.0, 'cy': 240.0}
        """
        given = {"fx": fx, "fy": fy, "cx": cx, "cy": cy}
        if K is not None:
            twice = ", ".join(name for name, value in given.items() if value is not None)
            if twice:
                raise ValueError(f"K and {twice} exclude each other; give one of them")
            given = _intrinsics_of(K)
        missing = [name for name, value in given.items() if value is None]
        if missing:
            raise TypeError(f"from_intrinsics needs {', '.join(missing)}, or K=")
        if width is None or height is None:
            raise TypeError("from_intrinsics needs width and height, the pixels of the image")
        matrix = np.eye(4) if pose is None else np.asarray(pose)
        if matrix.shape not in ((4, 4), (3, 4)) or matrix.dtype.kind not in "fiu":
            raise ValueError(
                f"pose has the shape {matrix.shape}; give a matrix of shape (4, 4) or (3, 4)"
            )
        if matrix.shape == (4, 4) and not np.array_equal(matrix[3], (0, 0, 0, 1)):
            raise ValueError(f"the last row of pose is {matrix[3]}; give 0, 0, 0, 1")
        matrix = matrix.astype(np.float64)
        shift = 0.5 - number("pixel_center", pixel_center)
        lens = [
            number("fx", given["fx"]),
            number("fy", given["fy"]),
            number("cx", given["cx"]) + shift,
            number("cy", given["cy"]) + shift,
        ]
        image = checked_size("(width, height)", (width, height))
        if convention not in ("opencv", "opengl"):
            raise ValueError(f"convention is {convention!r}; give 'opencv' or 'opengl'")
        right, second, third, eye = (vector("pose", column) for column in matrix[:3].T)
        _halfline.check_pose([right, second, third])
        if convention == "opencv":
            up, view = vector("pose", -matrix[:3, 1]), third
        else:
            up, view = second, vector("pose", -matrix[:3, 2])
        kind, words = "intrinsics", f"intrinsics={tuple(lens)}"
        if fisheye or distortion is not None:
            kind = "fisheye" if fisheye else "distorted"
            given_k = () if distortion is None else np.asarray(distortion, np.float64).ravel()
            lens += [number("distortion", x) for x in given_k]
            words = f"{kind}={tuple(lens)}"
        native = _halfline.Camera(eye, None, view, up, (kind, lens), image, None, None)
        return cls._of(native, f"{words}, size={image}, eye={eye}, view={view}, up={up}")

    @classmethod
    def panorama(
        cls,
        eye: ArrayLike,
        *,
        size: tuple[int, int],
        view: ArrayLike = (0, 0, -1),
        up: ArrayLike = (0, 1, 0),
    ) -> Camera:
        """A camera that sees all around: longitudes across, latitudes down, equirectangular.

        Args:
            eye: The origin of all rays.
            size: Columns and rows of the image, which span 360 and 180 degrees.
            view: The direction in the middle of the image.
            up: Up direction of the scene.

        >>> import halfline as hl
        >>> hl.Camera.panorama((0, 0, 0), size=(720, 360)).size
        (720, 360)
        """
        image = checked_size("size", size)
        pose = vector("eye", eye), None, vector("view", view), vector("up", up)
        lens = f"{_NAMED}equirectangular", [math.nan] * 5
        native = _halfline.Camera(*pose, lens, image, None, None)
        return cls._of(native, f"panorama=True, size={image}, eye={pose[0]}")

    @classmethod
    def fit(
        cls,
        scene: Spheres,
        *,
        focus: ArrayLike | str | None = None,
        view: ArrayLike | str | None = None,
        up: ArrayLike | None = None,
        vfov: float | None = None,
        lens: Literal["fisheye", "opencv"] | None = None,
        intrinsics: tuple[float, float, float, float] | None = None,
        lens_coefficients: ArrayLike | None = None,
        orthographic: bool = False,
        size: tuple[int, int] | None = None,
        margin: float | None = None,
        share: float = 1.0,
    ) -> Camera:
        """The nearest camera in this direction that shows all spheres of ``scene``, or the
        spheres of ``focus`` within the whole scene.

        Args:
            scene: The scene.
            focus: The spheres to frame: a mask of shape (n,), bool, in the order of ids, or an
                expression for `Scene.select`. Where the eye would be inside of a sphere, it steps
                back and the view narrows.
            view: Direction to look in, or ``"front"`` (along -z, y up), ``"back"``, ``"left"``,
                ``"right"``, ``"top"``, ``"bottom"``, ``"iso"`` or ``"auto"``: the largest face of the
                spheres toward the eye and the longest axis across, or for ``focus`` from where least
                of it is hidden. By default ``"auto"`` with ``focus``, else ``"front"``.
            up: Up direction of the scene; y, or the up direction of a named view.
            vfov: Full vertical field of view, degrees; 30 by default, of a fisheye 180.
            lens: A lens as of `Camera`; all spheres are within 60 degrees from its axis.
            intrinsics: Focal lengths and principal point of such a lens, in pixels of ``size``.
            lens_coefficients: Its distortion.
            orthographic: Whether the rays are parallel; the height of the view is fitted.
            size: Columns and rows of the image; by default the scene's.
            margin: Share of the image that stays free around the spheres, 0.04 by default, 0.25 with
                ``focus``.
            share: The share of the spheres that the camera shows, without ``focus``: those that are
                farthest from the median of their centres are left out.
        """
        if orthographic and vfov is not None:
            raise ValueError("vfov and orthographic exclude each other; give one of them")
        named = _named_lens(lens, vfov, intrinsics, lens_coefficients)
        if named is not None and orthographic:
            raise ValueError("lens and orthographic exclude each other; give one of them")
        if named is not None and str(lens) == "equirectangular":
            raise ValueError(
                "an equirectangular picture shows the whole sphere; give Camera an eye"
            )
        native = native_scene(scene)
        image = native.size if size is None else checked_size("size", size)
        if named is not None:
            kind, numbers, _ = named
        elif orthographic:
            kind, numbers = "height", [1.0]
        else:
            kind, numbers = "vfov", [number("vfov", 30.0 if vfov is None else vfov), 1.0]
        if view is None:
            view = "front" if focus is None else "auto"
        if margin is None:
            margin = 0.04 if focus is None else 0.25
        fitted, warning = _halfline.fit_camera(
            native,
            None if isinstance(view, str) else vector("view", view),
            view if isinstance(view, str) else None,
            None if up is None else vector("up", up),
            (kind, numbers),
            image,
            number("margin", margin),
            None if focus is None else _mask(scene, focus),
            number("share", share),
        )
        if warning is not None:
            warnings.warn(warning, stacklevel=2)
        return cls._of(fitted, None)

    @classmethod
    def _of(cls, native: _halfline.Camera, words: str | None) -> Camera:
        camera = cls.__new__(cls)
        camera._native = native
        camera._words = words
        return camera

    @property
    def size(self) -> tuple[int, int] | None:
        """Columns and rows of the image that its intrinsics belong to; ``None`` for other
        cameras.
        """
        return self._native.size

    def record(self, size: tuple[int, int] | None = None) -> dict[str, Any]:
        """The camera in numbers for an image of this size: eye, view, up, viewport, distance,
        intrinsics.

        It is the object ``camera`` of a report, and gives the same rays in ``halfline render
        --camera-from``.

        >>> import halfline as hl
        >>> hl.Camera((0, 0, 5), viewport=(4, 3)).record((640, 480))["intrinsics"]
        {'fx': 160.0, 'fy': 160.0, 'cx': 320.0, 'cy': 240.0}
        """
        image = self.size or (512, 512) if size is None else checked_size("size", size)
        record: dict[str, Any] = json.loads(self._native.record(image))
        return record

    def __reduce__(self) -> tuple[Any, tuple[str, str | None]]:
        return _unpickled, (self._native.state(), self._words)

    def __repr__(self) -> str:
        if self._words is not None:
            return f"Camera({self._words})"
        record = self.record()
        words = [f"{name}={tuple(record[name])}" for name in ("eye", "view", "up")]
        height = record["viewport"][1]
        if self.size is not None:
            words.append(f"size={self.size}")
        elif record["distance"] is None:
            words.append(f"height={height:.6g}")
        else:
            words.append(
                f"vfov={math.degrees(2 * math.atan2(height / 2, record['distance'])):.6g}"
            )
        return f"Camera({', '.join(words)})"


def native_camera(camera: Camera) -> _halfline.Camera:
    """The native part of a `Camera`."""
    if not isinstance(camera, Camera):
        raise TypeError(f"camera is a {type(camera).__name__}; give a Camera")
    return camera._native


def read_cameras(
    path: str | PathLike[str],
    *,
    intrinsics: tuple[float, float, float, float] | None = None,
    vfov: float | None = None,
    size: tuple[int, int] | None = None,
) -> list[Camera]:
    """The cameras of a list: JSON of halfline, transforms.json of NeRF, poses with intrinsics, or
    CSV.

    Args:
        path: The file; see docs/film.md for the forms.
        intrinsics: ``(fx, fy, cx, cy)`` in pixels for cameras without a lens of their own.
        vfov: Vertical field of view in degrees for cameras without a lens and without intrinsics.
        size: Columns and rows of the images, if the list does not say them.
    """
    given = None if intrinsics is None else _four(intrinsics)
    image = None if size is None else checked_size("size", size)
    angle = None if vfov is None else number("vfov", vfov)
    return [
        Camera._of(native, None) for native in _halfline.read_cameras(path, given, angle, image)
    ]


def _intrinsics_of(matrix: ArrayLike) -> dict[str, Any]:
    """fx, fy, cx and cy of a matrix of intrinsics."""
    try:
        found = np.asarray(matrix)
    except ValueError:
        found = np.empty(0)
    if found.shape != (3, 3) or found.dtype.kind not in "fiu":
        raise ValueError(f"K has the shape {found.shape}; give a matrix of shape (3, 3)")
    if not np.array_equal(found[2], (0, 0, 1)):
        raise ValueError(
            f"the last row of K is {found[2]}; give 0, 0, 1 (divide K by its last number)"
        )
    if found[0, 1] != 0:
        raise ValueError(
            f"K has the skew {found[0, 1]} (row 0, column 1), and pixels are rectangles here; "
            "undistort the images to a K without skew, or trace the rays yourself"
        )
    if found[1, 0] != 0:
        raise ValueError(f"row 1, column 0 of K is {found[1, 0]}; give 0, or transpose K")
    (fx, _, cx), (_, fy, cy) = found[:2]
    return {"fx": float(fx), "fy": float(fy), "cx": float(cx), "cy": float(cy)}


def _four(intrinsics: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    if len(intrinsics) != 4:
        raise ValueError(f"intrinsics has {len(intrinsics)} numbers; give fx, fy, cx, cy")
    fx, fy, cx, cy = (number("intrinsics", value) for value in intrinsics)
    return fx, fy, cx, cy


def _named_lens(
    lens: str | None,
    vfov: float | None,
    intrinsics: tuple[float, float, float, float] | None,
    coefficients: ArrayLike | None,
) -> tuple[str, list[float], dict[str, Any]] | None:
    """The kind and the numbers of a lens with a name, and its keywords; ``None`` without one."""
    if lens is None:
        for name, value in (("intrinsics", intrinsics), ("lens_coefficients", coefficients)):
            if value is not None:
                raise ValueError(f"{name} belongs to a lens; give lens='opencv', or remove {name}")
        return None
    values: dict[str, Any] = {"lens": lens}
    numbers = [math.nan] * 5
    if vfov is not None:
        values["vfov"] = numbers[0] = number("vfov", vfov)
    if intrinsics is not None:
        values["intrinsics"] = _four(intrinsics)
        numbers[1:] = values["intrinsics"]
    if coefficients is not None:
        given = np.asarray(coefficients, np.float64).ravel()
        values["lens_coefficients"] = tuple(number("lens_coefficients", x) for x in given)
        numbers += values["lens_coefficients"]
    return f"{_NAMED}{lens}", numbers, values


def _mask(scene: Spheres, focus: ArrayLike | str) -> list[bool]:
    """The flags of ``focus``, one for each sphere."""
    mask = np.asarray(scene.select(focus) if isinstance(focus, str) else focus)
    if mask.dtype != np.bool_ or mask.shape != (len(scene),):
        raise ValueError(
            f"focus has the type {mask.dtype} and the shape {mask.shape}; "
            f"give a mask of bool with the shape ({len(scene)},)"
        )
    return [bool(flag) for flag in mask]


def _two(name: str, values: Any) -> tuple[float, float]:
    try:
        first, second = values
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {values!r}; give two numbers") from None
    return number(name, first), number(name, second)


def _unpickled(state: str, words: str | None) -> Camera:
    return Camera._of(_halfline.Camera.of_state(state), words)
