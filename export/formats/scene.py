"""What a file of several bodies holds: meshes, their colours, and where each of them stands."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int, Real, UInt8

from ifs.mesh import Mesh

FARTHEST = 1e12  # mm
FLATTEST = 1e-12

Colours = UInt8[np.ndarray, "_colours 4"]


class WrongMesh(ValueError):
    """A mesh that no file can hold: corners that are missing or not finite, no faces."""


class WrongScene(ValueError):
    """Bodies, colours or places that do not belong together."""


class WrongRecipe(ValueError):
    """A recipe or a title that is no text."""


@dataclass(frozen=True, eq=False)
class Body:
    """One mesh (mm) with its name and its colours.

    `colours` are red, green, blue and, if wanted, opacity from 0 to 255: one row for the whole body, or one
    for each face. For colours of patches, with the patch of each face in `patch`: `palette[patch]`.

    Raises `WrongScene` for colours that are none, or as many as neither 1 nor the faces.

    >>> Body(Mesh(np.eye(3), np.array([[0, 1, 2]])), "corner", np.array([[255, 0, 0]])).rgba().tolist()
    [[255, 0, 0, 255]]
    """

    mesh: Mesh
    name: str = ""
    colours: Real[np.ndarray, "rows channels"] | None = None

    def __post_init__(self):
        if not isinstance(self.mesh, Mesh):
            raise WrongScene(f"a body is a Mesh, found a {type(self.mesh).__name__}")
        if not isinstance(self.name, str):
            raise WrongScene(f"the name of a body is text, found {self.name!r}")
        if self.colours is None:
            return
        rows, channels = self.colours.shape
        if channels not in (3, 4) or rows not in (1, len(self.mesh.faces)):
            raise WrongScene(
                f"colours of shape {rows} x {channels} for {len(self.mesh.faces)} faces: 3 or 4 numbers are "
                "needed for the whole body, or for each face"
            )
        wrong = (self.colours < 0) | (self.colours > 255) | (self.colours != np.floor(self.colours))
        if wrong.any():
            row = int(np.argmax(wrong.any(axis=1)))
            raise WrongScene(f"colour {row} is {self.colours[row].tolist()}: whole numbers from 0 to 255")

    def rgba(self) -> UInt8[np.ndarray, "rows 4"]:
        """The colours with their opacity, 255 where none was given; no rows where there are none."""
        if self.colours is None:
            return np.zeros((0, 4), dtype=np.uint8)
        found = np.full((len(self.colours), 4), 255, dtype=np.uint8)
        found[:, : self.colours.shape[1]] = self.colours
        return found


@dataclass(frozen=True, eq=False)
class Place:
    """Where a body stands: `transform` takes its points, as columns with a 1 below, to their place in mm."""

    body: int
    transform: Float[np.ndarray, "4 4"] = field(default_factory=lambda: np.eye(4))


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies and their places; without places, each body once as it is.

    A body may stand at several places: 3MF and GLB keep it once. `together` makes all of it one object of
    the 3MF file, whose bodies keep their places to each other in a slicer; otherwise each place is an object.

    Raises `WrongScene` for places of bodies that are not there, and for transforms that are not finite,
    project, or flatten.

    >>> corner = Body(Mesh(np.eye(3), np.array([[0, 1, 2]])))
    >>> len(Scene((corner, corner)).stands)
    2
    """

    bodies: tuple[Body, ...]
    places: tuple[Place, ...] = ()
    together: bool = True

    def __post_init__(self):
        if not isinstance(self.bodies, tuple) or not all(isinstance(body, Body) for body in self.bodies):
            raise WrongScene("the bodies of a scene are a tuple of Body; write Scene((Body(mesh),))")
        if not self.bodies:
            raise WrongScene("a scene without bodies")
        for number, place in enumerate(self.places):
            if not isinstance(place.body, (int, np.integer)) or not 0 <= place.body < len(self.bodies):
                raise WrongScene(f"place {number} is of body {place.body}: there are {len(self.bodies)}")
            linear = place.transform[:3, :3]
            if not np.isfinite(place.transform).all() or (place.transform[3] != [0, 0, 0, 1]).any():
                raise WrongScene(f"the transform of place {number} is no affine map of finite numbers")
            if abs(np.linalg.det(linear)) <= FLATTEST * np.linalg.norm(linear) ** 3:
                raise WrongScene(f"the transform of place {number} flattens its body")

    @property
    def stands(self) -> tuple[Place, ...]:
        """The places, also where none were given."""
        return self.places or tuple(Place(number) for number in range(len(self.bodies)))


def scene_of(shape: Mesh | Scene, title: str = "") -> Scene:
    """A mesh as a scene of one body of this name. Raises `WrongMesh` for what is neither."""
    if not isinstance(shape, (Mesh, Scene)):
        raise WrongMesh(f"a Mesh or a Scene is written, found a {type(shape).__name__}: mesh it first")
    return shape if isinstance(shape, Scene) else Scene((Body(shape, title),))


def check_recipe(recipe: Mapping[str, str], title: str = "") -> None:
    """Raises `WrongRecipe` where a recipe or a title is no text, with the key."""
    if not isinstance(recipe, Mapping):
        raise WrongRecipe(f"a recipe has keys and values, found a {type(recipe).__name__}")
    for key, value in (*recipe.items(), ("title", title)):
        if not isinstance(key, str) or not isinstance(value, str):
            raise WrongRecipe(f"recipe {key!r} is {value!r}: text is needed; write str(...)")


def check_scene(scene: Scene) -> None:
    """Raises `WrongMesh` where a body is no mesh of faces in space, with the vertex or the face."""
    for number, body in enumerate(scene.bodies):
        mesh, where = body.mesh, f"body {number}: " if len(scene.bodies) > 1 else ""
        if mesh.vertices.shape[1] > 3:
            raise WrongMesh(f"{where}points of {mesh.vertices.shape[1]} coordinates: files hold up to 3")
        if not len(mesh.faces) or mesh.faces.shape[1] < 3:
            raise WrongMesh(f"{where}a mesh of {len(mesh.faces)} faces of {mesh.faces.shape[1]} corners")
        low, high = mesh.vertices.min(), mesh.vertices.max()  # nan where one is
        if not (low > -FARTHEST and high < FARTHEST):
            wrong = int(np.argmin((np.abs(mesh.vertices) < FARTHEST).all(axis=1)))
            raise WrongMesh(
                f"{where}vertex {wrong} is {mesh.vertices[wrong].tolist()}: finite lengths below 10^12 mm"
            )
        corners = mesh.faces[:, :3]
        if corners.min() < 0 or mesh.faces.min() < -1 or mesh.faces.max() >= len(mesh.vertices):
            bad = (corners < 0).any(axis=1) | ((mesh.faces < -1) | (mesh.faces >= len(mesh.vertices))).any(
                axis=1
            )
            face = int(np.argmax(bad))
            raise WrongMesh(
                f"{where}face {face} is {mesh.faces[face].tolist()}: vertices from 0 to "
                f"{len(mesh.vertices) - 1} are there"
            )


def moved(mesh: Mesh, transform: Float[np.ndarray, "4 4"]) -> Mesh:
    """The mesh elsewhere; a mirrored one has its corners in the other order.

    >>> mirrored = moved(Mesh(np.eye(3), np.array([[0, 1, 2]])), np.diag([-1.0, 1, 1, 1]))
    >>> mirrored.vertices[0].tolist(), mirrored.faces.tolist()
    ([-1.0, 0.0, 0.0], [[2, 1, 0]])
    """
    if (transform == np.eye(4)).all():
        return mesh
    points = mesh.points_3d() @ transform[:3, :3].T + transform[:3, 3]
    if not mirrors(transform):
        return Mesh(points, mesh.faces)
    turned = mesh.faces[:, ::-1]
    # the padding stays at the end
    order = np.argsort(turned < 0, axis=1, kind="stable")
    return Mesh(points, np.take_along_axis(turned, order, axis=1))


def mirrors(transform: Float[np.ndarray, "4 4"]) -> bool:
    """Whether a transform turns left into right."""
    return bool(np.linalg.det(transform[:3, :3]) < 0)


def placed(scene: Scene) -> Iterator[Body]:
    """The bodies at their places, one by one."""
    for place in scene.stands:
        body = scene.bodies[place.body]
        yield Body(moved(body.mesh, place.transform), body.name, body.colours)


def triangle_colours(body: Body) -> tuple[Colours, Int[np.ndarray, " _triangles"]]:
    """The colours that occur, in rising order, and that of each of `triangles(mesh)`."""
    rgba, faces = body.rgba(), triangle_faces(body.mesh)
    if len(rgba) <= 1:
        return rgba, np.zeros(len(faces), dtype=np.int64)
    packed, which = np.unique(rgba.view(">u4").ravel(), return_inverse=True)
    return packed.view(np.uint8).reshape(-1, 4), which[faces]


def triangles(mesh: Mesh) -> Int[np.ndarray, "_triangles 3"]:
    """`mesh.triangles()`, without a copy where all faces are triangles."""
    return mesh.faces if mesh.faces.shape[1] == 3 else mesh.triangles()


def triangle_faces(mesh: Mesh) -> Int[np.ndarray, " _triangles"]:
    """The face of each of `triangles(mesh)`."""
    corners = mesh.faces.shape[1]
    if corners == 3:
        return np.arange(len(mesh.faces))
    found = [np.nonzero(mesh.faces[:, corner] >= 0)[0] for corner in range(2, corners)]
    return np.concatenate(found)
