"""Keywords of readings, renderings and files, and their types: the options of the command, with its help.

A test of the command writes this file, and the native module checks the values.

In the help, ``EXPR=X`` is ``{expression: x}`` here, numbers between commas are a tuple, and an option that may be repeated is a list.
``None`` and ``False`` stand for the default.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from os import PathLike
from typing import Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import Color

Path = str | PathLike[str]

Aov = Literal[
    "color",
    "distance",
    "depth",
    "normal",
    "position",
    "id",
    "mask",
    "certainty",
    "bound",
    "alpha",
    "shadow",
    "occlusion",
]


class ReadOptions(TypedDict, total=False):
    """Keywords of `read` and `read_frames`: options of ``halfline render``, where docs/reading.md
    explains them.
    """

    format: str | None
    """File format, if neither content nor name show it: toml, nff, xyz, pdb, pqr, pdbqt, gro,
    ptx, poscar, cif, data, dump, ply, csv, npy, npz, xtc, trr, dcd, nc, pcd, las, pts, gsd, vtk,
    e57.
    """
    columns: str | Mapping[str, str | int] | None
    """Columns of a table by meaning, with names or numbers from 1, such as
    x=pos_x,y=pos_y,z=pos_z or x=1,y=2,z=3,radius=4; meanings are x, y, z, radius, diameter, r, g,
    b, element. With numbers only the table needs no header.
    """
    atom_style: str | None
    """Atom style of a LAMMPS data file, in place of that behind ``Atoms #``: full, sphere, ...,
    "hybrid charge sphere", or the columns such as "id type q x y z".
    """
    hold: Literal["first", "none"]
    """Frames that give a sequence its camera, default radii and range of colours: first (frame of
    the file), all (frames of the file, which is read twice), none (each frame by itself)
    [default: first].
    """
    topology: Path | None
    """File with the atoms of a trajectory, such as PDB, GRO or LAMMPS data: the elements, radii,
    colours and columns that its frames (xtc, trr, dcd, dump, xyz, ...) lack, by their ids where
    both have them.
    """
    add: Path | Iterable[Path]
    """Another file of particles, in the same picture; may be repeated. The column file has the
    name of each particle's file without its extension. A file with one frame is in every frame of
    the others.
    """
    identity: str | None
    """Column that identifies particles: all frames of a film have the order of the first,
    whatever the order of their rows; row leaves them as they are [default: id, in dumps and
    extended XYZ that have it].
    """
    model: int | None
    """Model number in a PDB or mmCIF file."""
    altloc: str
    """Alternate locations of atoms: all, highest (occupancy), or an identifier [default: all]."""
    assembly: str | int | None
    """Biological assembly to build, by its identifier, such as 1."""
    as_listed: bool
    """Takes the atoms of a small-molecule CIF as listed; by default its symmetry fills the cell.
    """
    strict: bool
    """Fails if the scene contains anything but spheres."""
    skip_invalid: bool
    """Leaves out rows of tables, PTS, XYZ, LAMMPS dump, PLY, PCD, LAS, NPY and NPZ whose
    coordinates are not finite numbers or whose radius is not positive, and counts them; otherwise
    the first one is an error.
    """
    select: str | Iterable[str]
    """Takes only the particles that an expression selects, such as "protein and not name H*",
    "chain A B", "resid 10:20", "element C N", "type 2", "bfactor < 30", "within 5 of (resname
    HEM)"; if repeated, the particles that any selects.
    """
    hide: str | Iterable[str]
    """Leaves out the particles that an expression selects; may be repeated."""
    radii: Literal["vdw", "covalent"]
    """Radii of elements: vdw (van der Waals), covalent [default: vdw]."""
    radius: float | Mapping[str, float] | None
    """Radius of all spheres, or with EXPR=X of selected ones; overrides the file. Repeated, later
    ones win.
    """
    radius_scale: float
    """Multiplies every radius [default: 1]."""
    move: Mapping[str, ArrayLike]
    """Moves the particles that EXPR selects by X,Y,Z, such as 'file model=0,0,30'; selections and
    colours see where the file has them. Repeated, later ones win.
    """
    wrap: bool
    """Moves every particle into the periodic cell of the file, before copies."""
    unwrap: bool
    """Makes molecules whole that the cell cuts: by the image flags ix, iy, iz, else along bonds
    (by distance, where elements are known) and by the numbers mol of molecules or by residues. A
    warning says what stays cut.
    """
    copies: tuple[int, int, int] | None
    """Periodic copies along the three edges of the file's cell, original included."""
    clip: ArrayLike
    """Removes spheres whose centre c has X,Y,Z . c > D; may be repeated."""
    cell: bool | float
    """Draws the edges of the file's periodic cell with beads, of this radius if given."""
    color: Color | Mapping[str, Color] | None
    """Colour of all spheres, or with EXPR=C of selected ones: a CSS name such as red, #rgb or
    #rrggbb in sRGB, r,g,b in linear RGB, or element for the colours of the elements; a caption is
    the name of EXPR in the legend. Repeated, later ones win.
    """
    opacity: float | Mapping[str, float] | None
    """Opacity in pictures of all spheres, or with EXPR=A of selected ones: above 0, and at most
    1; a caption is the name of EXPR in the legend. Repeated, later ones win.
    """
    material: str | Mapping[str, str] | None
    """Material in pictures of all spheres, or with EXPR=M of selected ones: matte, plastic (with
    highlights of lights), metal (a mirror of its colour), glass. Repeated, later ones win.
    """
    shine: float | None
    """Exponent of the highlights of plastic; the greater, the smaller they are [default: 40]."""
    color_by: str | Iterable[str] | None
    """Colours by element, chain, x, y, z, distance (from the middle), or any column of the file;
    several columns (vx,vy,vz) by their length.
    """
    map: Path | ArrayLike | Callable[[NDArray[np.float64]], ArrayLike] | None
    """Colour map: viridis, inferno, magma, plasma, cividis, cubehelix, turbo, rdylbu, bwr,
    coolwarm, batlow, roma, vik, plddt, grays, category [default: category for names, else
    viridis]. NAME_r reverses it; plddt has four classes from 0 to 100; a name with a dot is a
    file of colours (CSV, JSON).
    """
    range: tuple[float | str, float | str] | None
    """Values at the ends of the colour map, or their percentiles, such as 1%,99% [default:
    minimum and maximum].
    """
    log: bool
    """Uses a logarithmic colour scale."""
    nan_color: Color | None
    """Colour of particles that color_by has no number for, as of background [default: grey]."""
    legend_title: str | None
    """Title of the legend, where one is drawn, such as 'speed / km/s', in place of the name of
    what is coloured.
    """


class Options(TypedDict, total=False):
    """Keywords of `Renderer.render`, `Renderer.render_many` and `Renderer.plan`: options of
    ``halfline render``.
    """

    aovs: Aov | Iterable[Aov]
    """The buffers; ``id`` is always there. By default ``color``."""
    dtype: Literal["float32", "float64"]
    """The type of the arrays distance, depth and position: float64, or the nearest float32 (ties
    to even; a miss is still +inf or NaN, and so +inf is what exceeds 3.4e38). Files hold float64.
    """
    cell: bool | float
    """Draws the edges of the file's periodic cell with beads, of this radius if given."""
    cut: ArrayLike
    """Cuts spheres by a plane: what has X,Y,Z . p > D is removed, and spheres that the plane
    passes through show their inside. May be repeated: what one plane removes is removed.
    """
    cut_slab: ArrayLike
    """Keeps a slab, A <= X,Y,Z . p <= B, between two planes that cut spheres."""
    cut_at: str | Iterable[str]
    """Cuts spheres by the plane through the mean of the centres that EXPR selects. X,Y,Z points
    to what is removed [default: back along the view, so that the camera looks at the cut].
    """
    cut_only: str | None
    """Planes cut only the spheres that EXPR selects; the others stay whole."""
    cut_color: Color | Mapping[str, Color] | None
    """Colour of the faces that planes cut, or with EXPR=C of the faces of selected spheres, as
    color takes it [default: the colour of each sphere]. Repeated, later ones win.
    """
    size: tuple[int, int | None] | None
    """Columns and rows of the image [default: the scene file's, else (512, 512)]; (columns, None)
    takes the rows that the framed spheres fill. With a vfov the width of the view follows; a
    viewport keeps its size.
    """
    samples: int | None
    """Samples per pixel for anti-aliasing of colour and alpha, rounded up to a square number.
    Other buffers use the pixel's centre [default: the scene file's, else 1, and 4 in the look
    soft].
    """
    least_size: float | None
    """Enlarges spheres that would be less than so many pixels wide, in pictures and all buffers.
    """
    seed: int
    """Seed of the sample positions [default: 0]."""
    exposure: float
    """Multiplies the light of pictures in 8 and 16 bits by 2 to this power. Linear files (.exr,
    .npy, .npz, .pfm, .raw) keep the light as it is [default: 0].
    """
    tone: Literal["linear", "soft"] | None
    """Light beyond 1 in pictures in 8 and 16 bits: linear (cut off), soft (the colour becomes
    whiter, so that shapes stay visible) [default: soft where lights or a sky light the picture,
    else linear].
    """
    shade: Literal["headlight", "flat", "normal"] | None
    """Shading: flat (the sphere's colour), normal (as a colour), headlight (lights, or a light at
    the eye in a scene without any). A picture of particles then has the look plain [default:
    headlight; see look].
    """
    look: Literal["plain", "soft", "figure"] | None
    """Look of the picture, to which other options add: plain (nothing), soft (samples 4,
    silhouette, a sky with 3 rays from each pixel's centre, and a light from above left if the
    scene has none), figure (samples 16, silhouette, and a sky with 8 rays) [default: the scene
    file's, else plain; for particles soft, unless shade or --stream is given].
    """
    occlusion: bool | int
    """Ambient occlusion: a white sky, parts of it hidden by other spheres; N rays for each point
    [default: the scene file's, else 16].
    """
    reach: float | None
    """Spheres farther than this from a point, in scene units, hide nothing of the sky [default:
    the scene file's, else no limit].
    """
    sun: ArrayLike
    """Adds a white light infinitely far in this direction; may be repeated."""
    shadows: bool
    """Lights cast shadows, as lights of scene files always do; without any light, adds one from
    above left of the camera.
    """
    bounces: int | None
    """The most bounces of a ray at mirrors and in glass, up to 64; 0 switches them off [default:
    6].
    """
    silhouette: bool
    """Draws dark lines where the depth jumps."""
    outline_width: float | None
    """Width of these lines, from 0.1 to 40 pixels; below 1.3 they become paler instead of
    narrower [default: 1.3].
    """
    outline_color: Color | None
    """Colour of these lines, as of background [default: black]."""
    depth_cue: bool
    """Fades colours to the background with depth."""
    depth_cue_strength: float | None
    """Share of the background in the colour of the farthest sphere, above 0 and at most 1
    [default: 0.6].
    """
    layers: int | None
    """Shows so many translucent spheres before the first opaque one, the nearest, up to 64; see
    opacity [default: 1].
    """
    ghost_rim: bool
    """Lets translucent spheres grow opaque toward their rim, so that their shapes are seen."""
    opacity_shadows: bool
    """Lets translucent spheres block lights and sky as opaque ones do."""
    background: Color | None
    """Background colour: a CSS name such as white, #rgb or #rrggbb in sRGB, or r,g,b in linear
    RGB.
    """
    legend: bool | Path
    """Draws the legend of the colours, of color_by or else of the elements, inside the picture:
    right (the default), top-left, top-right, bottom-left, bottom-right. Spheres that are framed
    lie beside it. CORNER may follow = or a space. A file name (.svg, .png) writes it to a file of
    its own.
    """
    label: str | None
    """Draws text at the top left; {frame}, {file} and {count} are replaced by the frame's number,
    the file's name and the number of spheres, {time} and {step} by the frame's time and step if
    its file has them.
    """
    scale_bar: bool | str
    """Draws a bar of a round length in scene units at the bottom left, with this unit in its
    label. With a perspective camera the length is that at the distance of the scene's middle.
    """
    mark: Mapping[str, str]
    """Writes a text at what an expression selects: at each residue, or at each particle of files
    without residues. {COLUMN} in the text is replaced by the value of a column. A text has no
    equals sign; the option may be repeated.
    """
    mark_one: Mapping[str, str]
    """Writes a text once, at what an expression selects as a whole, such as 'chain A=receptor'.
    Otherwise as mark.
    """
    mark_all: bool
    """Writes the texts of mark and mark_one also at what is hidden."""
    accuracy: Literal["auto", "fast", "certified", "exact"]
    """Accuracy of the answers: auto, fast, certified, exact [default: auto]."""
    method: str | None
    """Uses one intersection method, uncertified: textbook, unit, geometric, stable, f64,
    double-float.
    """
    tolerance: float | None
    """Allowed error of distances (relative) and outlines (in radii), at least 2^-50. Certified
    answers stay within it (1e-5 if not given); with accuracy auto, the cheapest method that does
    is used.
    """
    transparent: bool
    """Makes the background transparent; alpha is stored in .png, .exr, .npz, .tif and .webp."""
    cryptomatte: str | Iterable[str]
    """Adds Cryptomatte layers to the .exr of -o, for masks in compositors: id (the number of each
    sphere), residue, or a column such as chain, element or type. Each layer has the six objects
    that cover most of a pixel, by its samples. May be given several times.
    """
    crop: tuple[int, int, int, int] | None
    """Renders only columns X0 to X1 and rows Y0 to Y1, counted from 0 at the top left, ends
    excluded.
    """


class PartOptions(TypedDict, total=False):
    """Keywords of `Sieve` and `sift`: of the frame of all parts, which needs the same ones."""

    cut: ArrayLike
    """Cuts spheres by a plane: what has X,Y,Z . p > D is removed, and spheres that the plane
    passes through show their inside. May be repeated: what one plane removes is removed.
    """
    cut_slab: ArrayLike
    """Keeps a slab, A <= X,Y,Z . p <= B, between two planes that cut spheres."""
    samples: int | None
    """Samples per pixel for anti-aliasing of colour and alpha, rounded up to a square number.
    Other buffers use the pixel's centre [default: the scene file's, else 1, and 4 in the look
    soft].
    """
    seed: int
    """Seed of the sample positions [default: 0]."""
    outline_width: float | None
    """Width of these lines, from 0.1 to 40 pixels; below 1.3 they become paler instead of
    narrower [default: 1.3].
    """
    tolerance: float | None
    """Allowed error of distances (relative) and outlines (in radii), at least 2^-50. Certified
    answers stay within it (1e-5 if not given); with accuracy auto, the cheapest method that does
    is used.
    """
    crop: tuple[int, int, int, int] | None
    """Renders only columns X0 to X1 and rows Y0 to Y1, counted from 0 at the top left, ends
    excluded.
    """


class SaveOptions(TypedDict, total=False):
    """Keywords of `Frame.save` and `Frame.to_png`."""

    bits: Literal[8, 16]
    """Bits per component in PNG and TIFF: 8, 16 [default: 8]."""
    dpi: float | None
    """Pixels per inch, stored in .png, .tif, .jpg, .webp, .svg and .pdf for print; size gives the
    number of pixels, or it follows from a size in millimetres.
    """
    trim: bool
    """Cuts the borders in which nothing is shown off the picture and all buffers; what remains
    has its place in the frame in its files, as a crop has.
    """
    unit: float
    """Scene units per level of distance and depth in PNG, up to level 65535; 0 is a miss
    [default: 0.001].
    """
    no_return: Literal["inf", "nan", "zero"]
    """Distance and depth of a miss: inf, nan (as in ROS), zero (as in OpenCV); in PNG always 0
    [default: inf].
    """


class VectorOptions(Options, total=False):
    """Keywords of `Scene.vector`: keywords of a rendering, and its own."""

    group: str | Iterable[str]
    """Divides the paths of a figure (.svg, .pdf) into groups by a column, such as residue, chain
    or element; several give groups of all their values. With shade flat all of one colour in a
    group is one path [default: a path for each sphere].
    """
    detail: float
    """Leaves out of a figure what is smaller than so many pixels [default: 0.1]."""
    dpi: float | None
    """Pixels per inch, stored in .png, .tif, .jpg, .webp, .svg and .pdf for print; size gives the
    number of pixels, or it follows from a size in millimetres.
    """
