"""A half lap as a deck in the manner of Abaqus/CAE: parts, instances, sets in pieces, ties."""

import numpy as np
import xarray as xr

from boltjoint.structure.elements.kinds import KINDS

#: of instances, in degrees about an axis along z through a point
_TURNS = (0.0, 90.0, -35.0, 180.0)


def deck_of(assembly, preload):
    """Text of the deck in mm, t and s.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
    preload
        Of each bolt [N].
    """
    # numbers of NumPy in their own digits
    return "".join(_Writer(assembly).lines(float(preload)))


def deck_of_finer(assembly, preload, *, halvings=0, tetrahedra=False):
    """The same of finer elements in the same shape, which is that of its bricks.

    Parameters
    ----------
    assembly, preload
        As of ``deck_of``.
    halvings
        How often bricks are cut into eight.
    tetrahedra
        Whether six 10-node tetrahedra then take the place of each.
    """
    writer = _Writer(assembly)
    for _ in range(halvings):
        writer.halve()
    if tetrahedra:
        writer.divide_into_tetrahedra()
    return "".join(writer.lines(float(preload)))


def tetrahedra_of(hexahedra):
    """Six tetrahedra of each brick, shape (6 bricks, 4), that share faces with their neighbours.

    Faces are cut from the smallest of their nodes, bricks into tetrahedra with theirs as apex.

    References
    ----------
    J. Dompierre, P. Labbe, M.-G. Vallet, R. Camarero: How to subdivide pyramids, prisms, and
    hexahedra into tetrahedra. 8th International Meshing Roundtable, 1999.
    """
    found = []
    for brick in hexahedra:
        apex = brick.min()
        for corners in KINDS["C3D8"].corners_of_faces:
            face = brick[list(corners)]
            if apex in face:
                continue
            a, b, c, d = np.roll(face, -face.argmin())
            # faces are seen from outside, the apex lies inside
            found += [(a, c, b, apex), (a, d, c, apex)]
    return np.array(found)


_BRICK = KINDS["C3D20"]
#: of a brick, whose middles are new nodes where it is cut: edges, faces, itself
_PARENTS = _BRICK.functions.edges, _BRICK.corners_of_faces, (tuple(range(8)),)


def _eighths():
    """Nodes of the eight bricks in one, by their number among its corners and new nodes."""
    corner = _BRICK.functions.corner
    place = [corner, *(corner[np.array(each)].mean(axis=1) for each in _PARENTS)]
    number = {tuple(x): i for i, x in enumerate(np.vstack(place).tolist())}
    return np.array([[number[tuple(x)] for x in (c + corner) / 2] for c in corner])


class _Writer:
    kind = KINDS["C3D8R"]

    def __init__(self, assembly):
        self.assembly = assembly
        self.place = 1e3 * assembly["coordinate"].to_numpy()
        self.part = assembly["part"].to_numpy()
        hexahedra = assembly["connectivity"].transpose("element", "corner").to_numpy()
        self.section = assembly["section_node"].to_numpy()
        # both sides of a section are one body in a deck, which its own keyword parts
        same = np.arange(len(self.place))
        same[self.section[:, 1]] = self.section[:, 0]
        self.node = same[hexahedra]
        self.added = []
        self._number()

    def halve(self):
        """Cut every brick into eight."""
        middles = [self._middles(self.node[:, np.array(parents)]) for parents in _PARENTS]
        self.node = np.hstack([self.node, *middles])[:, _eighths()].reshape(-1, 8)
        self._number(8)

    def divide_into_tetrahedra(self):
        """Put six 10-node tetrahedra in the place of every brick."""
        self.kind = KINDS["C3D10"]
        corner = tetrahedra_of(self.node)
        self.node = np.hstack(
            [corner, self._middles(corner[:, np.array(self.kind.functions.edges)])]
        )
        self._number(6)

    def _middles(self, parents):
        """New nodes in the middle of others, shape (elements, places, nodes): one for the same."""
        unique, number = np.unique(
            np.sort(parents, axis=-1).reshape(-1, parents.shape[-1]), axis=0, return_inverse=True
        )
        first = len(self.place)
        self.place = np.vstack([self.place, self.place[unique].mean(axis=1)])
        self.added.append((first, unique))
        return first + number.reshape(parents.shape[:2])

    def _number(self, pieces=1):
        """Elements and nodes of every part, each of whose elements became some pieces."""
        self.part = np.repeat(self.part, pieces)
        self.numbers = {
            part: np.unique(self.node[self.part == part]) for part in np.unique(self.part)
        }
        self.element = {part: np.flatnonzero(self.part == part) for part in self.numbers}

    def _with_middles(self, node):
        """Nodes, with those that were added in the middle of some of them."""
        for first, parents in self.added:
            inside = np.flatnonzero(np.isin(parents, node).all(axis=1))
            node = np.concatenate([node, first + inside])
        return node

    def lines(self, preload):
        yield "*Heading\n** PARTS\n"
        for part, node in self.numbers.items():
            yield f"*Part, name=part-{part}\n*Node\n"
            for label, place in enumerate(self._local(part, self.place[node]), 1):
                yield f"{label}, {', '.join(map(repr, place.tolist()))}\n"
            yield f"*Element, type={self.kind.name}\n"
            for label, element in enumerate(self.element[part], 1):
                corners = np.searchsorted(node, self.node[element]) + 1
                yield f"{label}, {', '.join(map(str, corners))}\n"
            count = len(self.element[part])
            yield f"*Elset, elset=all, generate\n1, {count}, 1\n"
            yield "*Solid Section, elset=all, material=steel\n,\n*End Part\n"
        yield "*Assembly, name=Assembly\n"
        for part in self.numbers:
            yield f"*Instance, name=part-{part}-1, part=part-{part}\n"
            shift, angle = self._motion(part)
            yield f"{', '.join(map(repr, shift))}\n"
            if angle:
                end = [*shift[:2], shift[2] + 1.0]
                axis = ", ".join(map(repr, [*shift, *end]))
                yield f"{axis}, {angle!r}\n"
            yield "*End Instance\n"
        yield from self._surfaces_of_pairs()
        yield from self._ties()
        yield from self._sections()
        yield "*End Assembly\n"
        density, modulus, ratio = (
            self.assembly[name].item() for name in ("density", "youngs_modulus", "poissons_ratio")
        )
        yield (
            f"*Material, name=steel\n*Density\n{1e-12 * density!r},\n*Elastic\n"
            f"{1e-6 * modulus!r}, {ratio!r}\n"
        )
        yield "*Boundary\nheld, ENCASTRE\n*Step, name=load\n*Static\n"
        for bolt in range(self.assembly.sizes["bolt"]):
            yield f"*Cload\nlength-{bolt}, 1, {preload!r}\n"
        yield "*End Step\n"

    def _motion(self, part):
        part = int(part)
        return [10.0 * part, -3.0 * part, 0.5 * part], _TURNS[part % len(_TURNS)]

    def _local(self, part, place):
        """Coordinates of the part, which its instance moves back."""
        shift, angle = self._motion(part)
        back = -np.deg2rad(angle)
        turn = np.array(
            [[np.cos(back), -np.sin(back), 0], [np.sin(back), np.cos(back), 0], [0, 0, 1]]
        )
        # moved by the shift, then turned about an axis through that point
        return (place - shift) @ turn.T

    def _faces(self, part, node):
        """Elements of a part, by the number of the face whose nodes are all among some."""
        within = np.isin(self.node[self.element[part]], node)
        return {
            number: np.flatnonzero(within[:, face].all(axis=1)) + 1
            for number, face in enumerate(self.kind.faces, 1)
            if within[:, face].all(axis=1).any()
        }

    def _surface(self, name, part, node):
        pieces = self._faces(part, node)
        for number, element in pieces.items():
            yield f"*Elset, elset=_{name}_S{number}, internal, instance=part-{part}-1\n"
            for start in range(0, len(element), 16):
                yield f"{', '.join(map(str, element[start : start + 16]))}\n"
        yield f"*Surface, type=ELEMENT, name={name}\n"
        for number in pieces:
            yield f"_{name}_S{number}, S{number}\n"

    def _surfaces_of_pairs(self):
        pair_node = self.assembly["pair_node"].to_numpy()
        for side, (name, part) in enumerate((("lap_a", 0), ("lap_b", 1))):
            yield from self._surface(name, part, self._with_middles(pair_node[:, side]))
        clamped = self._with_middles(self.assembly["clamped_node"].to_numpy())
        held = np.searchsorted(self.numbers[0], clamped) + 1
        yield "*Nset, nset=held, instance=part-0-1\n"
        yield "".join(f"{each},\n" for each in held)

    def _ties(self):
        parts = list(self.numbers)
        for slave in parts[2:]:
            for master in parts[:slave]:
                shared = np.intersect1d(self.numbers[slave], self.numbers[master])
                if not shared.size:
                    continue
                names = f"s{slave}_{master}", f"m{master}_{slave}"
                for name, part in zip(names, (slave, master), strict=True):
                    yield from self._surface(name, part, shared)
                yield f"*Tie, name=tie-{slave}-{master}, adjust=yes\n{names[0]}, {names[1]}\n"

    def _sections(self):
        of_bolt = self.assembly["section_bolt"].to_numpy()
        for bolt in range(self.assembly.sizes["bolt"]):
            node = self._with_middles(self.section[of_bolt == bolt, 0])
            part = next(p for p in self.numbers if p > 1 and np.isin(node, self.numbers[p]).all())
            # faces of the elements below, whose outward normal is along z
            pieces = self._faces(part, node)
            below = {}
            for number, elements in pieces.items():
                place = self.place[self.node[self.element[part][elements - 1]]].mean(axis=1)
                kept = elements[place[:, 2] < self.place[node[0], 2]]
                if kept.size:
                    below[number] = kept
            for number, elements in below.items():
                yield f"*Elset, elset=_cut{bolt}_S{number}, internal, instance=part-{part}-1\n"
                yield "".join(f"{each},\n" for each in elements)
            yield f"*Surface, type=ELEMENT, name=cut-{bolt}\n"
            yield "".join(f"_cut{bolt}_S{number}, S{number}\n" for number in below)
            yield f"*Node, nset=length-{bolt}\n{1000 + bolt}, 0., 0., 0.\n"
            yield f"*Pre-tension Section, surface=cut-{bolt}, node={1000 + bolt}\n0., 0., 1.\n"


def deck_of_bodies(mesh, material, preload):
    """The deck of two bodies and their bolts, by a mesh of ``extrusion.bodies``."""
    dims = ("section_pair", "section_side")
    assembly = xr.Dataset(
        {
            "coordinate": (("node", "axis"), mesh.coordinate),
            "connectivity": (("element", "corner"), mesh.hexahedron),
            "part": ("element", mesh.part),
            "pair_node": (("pair", "side"), mesh.pair),
            "section_node": (dims, mesh.section),
            "section_bolt": ("section_pair", mesh.bolt_of_pair),
            "bolt_position": (("bolt", "axis"), mesh.bolt_position),
            "clamped_node": ("clamped", mesh.held),
            "density": 1.0 * material["density_kg_per_m3"],
            "youngs_modulus": 1e9 * material["youngs_modulus_GPa"],
            "poissons_ratio": material["poissons_ratio"],
        }
    )
    return deck_of(assembly, preload)
