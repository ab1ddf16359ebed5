"""Keywords of decks that tell materials, constraints, bolts, contact, supports and loads."""

from boltjoint.structure.makers.deck import lines
from boltjoint.structure.makers.deck.content import (
    Beam,
    Boundary,
    ContactPair,
    Coupling,
    Equation,
    Interaction,
    Load,
    Material,
    PointProperty,
    PretensionSection,
    Reading,
    Reference,
    Section,
    Term,
    Tie,
)
from boltjoint.structure.makers.deck.lines import Block

#: displacements that a word of BOUNDARY holds
_HELD = {
    "ENCASTRE": (1, 6),
    "PINNED": (1, 3),
    "XSYMM": (1, 1, 5, 6),
    "YSYMM": (2, 2, 4, 4, 6, 6),
    "ZSYMM": (3, 3, 4, 5),
}
_DOFS = 6


def _reference(reading: Reading, block: Block, row: int, column: int = 0) -> Reference:
    fields = block.fields(row)
    if len(fields) <= column or not fields[column]:
        raise block.refused(f"{block.rows[row]!r} has too few values", row)
    return Reference(fields[column], reading.scope, block.place_of(row))


def _named(reading: Reading, block: Block, option: str) -> Reference:
    return Reference(block.option(option), reading.scope, block.place)


def _required_row(block: Block) -> None:
    if not block.rows:
        raise block.refused("its data line is missing")


def material(reading: Reading, block: Block) -> None:
    """MATERIAL: a name, for what follows."""
    name = block.option("NAME")
    reading.material = Material(name, block.place)
    reading.deck.materials[name.upper()] = reading.material


def elastic(reading: Reading, block: Block) -> None:
    """ELASTIC: Young's modulus and Poisson's ratio, the first of a table over temperature."""
    if reading.material is None:
        raise block.refused("no *MATERIAL stands before it")
    kind = block.options.get("TYPE", "ISOTROPIC").upper()
    if not "ISOTROPIC".startswith(kind):
        raise block.refused(f"TYPE={kind} is not read: ISOTROPIC")
    _required_row(block)
    modulus, ratio = lines.reals(block, 0, 2)
    if not modulus > 0:
        raise block.refused(f"Young's modulus {modulus:g} must be greater than 0", 0)
    if not -1 < ratio < 0.5:
        raise block.refused(f"Poisson's ratio {ratio:g} must lie between -1 and 0.5", 0)
    reading.material.youngs_modulus, reading.material.poissons_ratio = modulus, ratio


def density(reading: Reading, block: Block) -> None:
    """DENSITY of a material."""
    if reading.material is None:
        raise block.refused("no *MATERIAL stands before it")
    _required_row(block)
    value = lines.reals(block, 0, 1)[0]
    if not value > 0:
        raise block.refused(f"density {value:g} must be greater than 0", 0)
    reading.material.density = value


def solid_section(reading: Reading, block: Block) -> None:
    """SOLID SECTION: material of a set of elements."""
    elements = _named(reading, block, "ELSET")
    reading.deck.sections.append(Section(elements, block.option("MATERIAL")))


def beam_section(reading: Reading, block: Block) -> None:
    """BEAM SECTION: material and cross-section of a set of beams, which are bolts."""
    kind = block.options.get("SECTION", "RECT").upper()
    sizes = {"CIRC": 1, "RECT": 2, "PIPE": 2}
    if kind not in sizes:
        raise block.refused(f"SECTION={kind} is not read: {', '.join(sizes)}")
    _required_row(block)
    lengths = tuple(lines.reals(block, 0, sizes[kind]))
    if not min(lengths) > 0:
        raise block.refused(f"sizes {lengths} must be greater than 0", 0)
    first_axis = tuple(lines.reals(block, 1, 3)) if len(block.rows) > 1 else (0.0, 0.0, -1.0)
    if not any(first_axis):
        raise block.refused("the first axis of the section has no direction", 1)
    elements, made_of = _named(reading, block, "ELSET"), block.option("MATERIAL")
    reading.deck.beams.append(Beam(elements, made_of, kind, lengths, first_axis, block.place))


def tie(reading: Reading, block: Block) -> None:
    """TIE: nodes of a surface that move with the faces of another."""
    tolerance = block.options.get("POSITION TOLERANCE")
    if "CYCLIC SYMMETRY" in block.options or "MULTISTAGE" in block.options:
        raise block.refused("ties of cyclic symmetry are not read")
    for row in range(len(block.rows)):
        reading.deck.ties.append(
            Tie(
                block.options.get("NAME", f"{len(reading.deck.ties) + 1}"),
                _reference(reading, block, row),
                _reference(reading, block, row, 1),
                None if tolerance is None else lines.real(block, -1, tolerance),
                block.place_of(row),
                block.options.get("ADJUST", "YES").upper() != "NO",
            )
        )


def equation(reading: Reading, block: Block) -> None:
    """EQUATION: numbers of terms, each followed by as many nodes, displacements and factors."""
    row = 0
    while row < len(block.rows):
        start = row
        count = lines.whole(block, row, block.fields(row)[0])
        if count < 1:
            raise block.refused(f"{count} terms: it must have at least 1", row)
        texts: list[tuple[int, str]] = []
        row += 1
        while len(texts) < 3 * count:
            if row == len(block.rows):
                raise block.refused(f"has fewer than {count} terms", start)
            texts += [(row, field) for field in block.fields(row)]
            row += 1
        terms = []
        for number in range(count):
            (at, text), (_, dof), (_, factor) = texts[3 * number : 3 * number + 3]
            node = Reference(text, reading.scope, block.place_of(at))
            terms.append(Term(node, _dof(block, at, dof), lines.real(block, at, factor)))
        reading.deck.equations.append(Equation(tuple(terms), block.place_of(start)))


def _dof(block: Block, row: int, text: str) -> int:
    dof = lines.whole(block, row, text)
    if not 1 <= dof <= _DOFS:
        raise block.refused(f"displacement {dof} is not read: 1 to 6", row)
    return dof


def coupling(reading: Reading, block: Block) -> None:
    """COUPLING: a reference node and the nodes of a surface; what kind the next keyword tells."""
    name = block.options.get("CONSTRAINT NAME", "")
    nodes = _named(reading, block, "SURFACE")
    reference = _named(reading, block, "REF NODE")
    reading.coupling = Coupling(name, "", reference, nodes, True, (), block.place)
    reading.orientation = block.options.get("ORIENTATION", "")


def kinematic(reading: Reading, block: Block) -> None:
    """KINEMATIC: displacements of the nodes that follow the reference node."""
    if reading.coupling is None:
        raise block.refused("no *COUPLING stands before it")
    dofs: list[int] = []
    for row in range(len(block.rows)):
        bounds = [_dof(block, row, field) for field in block.fields(row) if field]
        dofs += range(bounds[0], bounds[-1] + 1)
    held = tuple(sorted({dof for dof in dofs or (1, 2, 3) if dof <= 3}))
    if reading.orientation and held != (1, 2, 3):
        raise block.refused(
            f"ORIENTATION={reading.orientation} of its *COUPLING is not read where some "
            "displacements are free: give all three"
        )
    coupling = reading.coupling._replace(kind="kinematic", dofs=held)
    reading.deck.couplings.append(coupling)
    reading.coupling = None


def distributing(reading: Reading, block: Block) -> None:
    """DISTRIBUTING: the reference node follows the mean motion of the nodes."""
    if reading.coupling is None:
        raise block.refused("no *COUPLING stands before it")
    method = block.options.get("WEIGHTING METHOD", "UNIFORM").upper()
    if method != "UNIFORM":
        raise block.refused(f"WEIGHTING METHOD={method} is not read: UNIFORM")
    coupling = reading.coupling._replace(kind="distributing", dofs=(1, 2, 3, 4, 5, 6))
    reading.deck.couplings.append(coupling)
    reading.coupling = None


def distributing_coupling(reading: Reading, block: Block) -> None:
    """DISTRIBUTING COUPLING of CalculiX: nodes with weights, for an element DCOUP3D."""
    elements = _named(reading, block, "ELSET")
    for row in range(len(block.rows)):
        weight = lines.reals(block, row, 1, 1)[0] or 1.0
        nodes = _reference(reading, block, row)
        dofs = (1, 2, 3, 4, 5, 6)
        reading.deck.couplings.append(
            Coupling("", "distributing", elements, nodes, False, dofs, block.place, (weight,))
        )


def rigid_body(reading: Reading, block: Block) -> None:
    """RIGID BODY: nodes of a set, or of elements of one, that move with a reference node."""
    kind = "elements" if block.options.get("ELSET") else "nodes"
    nodes = _named(reading, block, "ELSET" if kind == "elements" else "NSET")
    reference = _named(reading, block, "REF NODE")
    body = Coupling("rigid body", kind, reference, nodes, False, (1, 2, 3), block.place)
    reading.deck.rigid_bodies.append(body)


def pretension_section(reading: Reading, block: Block) -> None:
    """PRE-TENSION SECTION across a surface or a beam."""
    surface, element = (
        _named(reading, block, name) if block.options.get(name) else None
        for name in ("SURFACE", "ELEMENT")
    )
    if (surface is None) == (element is None):
        raise block.refused("SURFACE or ELEMENT must be given, and not both")
    x, y, z = lines.reals(block, 0, 3) if block.rows else (0.0, 0.0, 0.0)
    node = _named(reading, block, "NODE")
    section = PretensionSection(node, surface, element, (x, y, z), block.place)
    reading.deck.pretension.append(section)


def boundary(reading: Reading, block: Block) -> None:
    """BOUNDARY: held displacements, of which those of steps are no supports."""
    if block.options.get("TYPE", "DISPLACEMENT").upper() != "DISPLACEMENT":
        raise block.refused(f"TYPE={block.options['TYPE']} is not read")
    for row in range(len(block.rows)):
        nodes, fields = _reference(reading, block, row), block.fields(row)
        word = fields[1].upper() if len(fields) > 1 else ""
        if word in _HELD:
            spans = _HELD[word]
            ranges = [(spans[i], spans[i + 1], 0.0) for i in range(0, len(spans), 2)]
        else:
            first = _dof(block, row, word)
            last = _dof(block, row, fields[2]) if len(fields) > 2 and fields[2] else first
            value = lines.reals(block, row, 1, 3)[0]
            ranges = [(first, last, value)]
        for first, last, value in ranges:
            reading.deck.boundaries.append(Boundary(nodes, first, last, value, reading.step))


def cload(reading: Reading, block: Block) -> None:
    """CLOAD: forces, of which those of bolts are their preloads."""
    for row in range(len(block.rows)):
        fields = block.fields(row)
        nodes = _reference(reading, block, row)
        dof = _dof(block, row, fields[1] if len(fields) > 1 else "")
        force = lines.reals(block, row, 1, 2)[0]
        reading.deck.loads.append(Load(nodes, dof, force, reading.step))


def contact_pair(reading: Reading, block: Block) -> None:
    """CONTACT PAIR: pairs of surfaces in contact, each once and in one order."""
    interaction = block.options.get("INTERACTION", "")
    for row in range(len(block.rows)):
        slave, master = _reference(reading, block, row), _reference(reading, block, row, 1)
        for other in reading.deck.contact:
            if {_key(slave), _key(master)} == {_key(other.slave), _key(other.master)}:
                raise ValueError(
                    f"{block.place_of(row)}: *CONTACT PAIR: {slave.text} and {master.text} are a "
                    f"pair at {other.place} already"
                )
        reading.deck.contact.append(ContactPair(slave, master, interaction, block.place_of(row)))


def _key(surface: Reference) -> tuple[str, str]:
    return surface.scope, surface.text.upper()


def surface_interaction(reading: Reading, block: Block) -> None:
    """SURFACE INTERACTION: a name, for what follows."""
    name = block.option("NAME")
    reading.interaction = Interaction(name)
    reading.deck.interactions[name.upper()] = reading.interaction


def friction(reading: Reading, block: Block) -> None:
    """FRICTION: coefficient."""
    if reading.interaction is not None and block.rows:
        reading.interaction.friction_coefficient = lines.reals(block, 0, 1)[0]


def surface_behavior(reading: Reading, block: Block) -> None:
    """SURFACE BEHAVIOR: stiffness for each area where pressure and closure are proportional."""
    law = block.options.get("PRESSURE-OVERCLOSURE", "").upper()
    if reading.interaction is not None and block.rows and law == "LINEAR":
        stiffness = lines.reals(block, 0, 1)[0]
        reading.interaction.stiffness = stiffness if stiffness > 0 else None


def mass(reading: Reading, block: Block) -> None:
    """MASS of the elements MASS of a set."""
    _required_row(block)
    elements = _named(reading, block, "ELSET")
    reading.deck.masses.append(PointProperty(elements, lines.reals(block, 0, 1)[0]))


def spring(reading: Reading, block: Block) -> None:
    """SPRING: stiffness of the elements SPRINGA of a set, whose first data line is blank."""
    if "NONLINEAR" in block.options:
        raise block.refused("NONLINEAR is not read")
    # a blank line is none; degrees of freedom that stand there mean nothing for SPRINGA
    count, fields = len(block.rows), block.fields(0) if block.rows else []
    row = int(count > 1 or len(fields) > 1)
    if count > row + 1 or (row and not set(fields) <= set("123456")):
        raise block.refused("a stiffness that depends on temperature is not read")
    if count == row:
        raise block.refused("its second data line, the stiffness, is missing")
    elements = _named(reading, block, "ELSET")
    reading.deck.springs.append(PointProperty(elements, lines.reals(block, row, 1)[0]))


#: within steps too
IN_STEPS = {"BOUNDARY": boundary, "CLOAD": cload}
HANDLERS = IN_STEPS | {
    "MATERIAL": material,
    "ELASTIC": elastic,
    "DENSITY": density,
    "SOLID SECTION": solid_section,
    "BEAM SECTION": beam_section,
    "TIE": tie,
    "EQUATION": equation,
    "COUPLING": coupling,
    "KINEMATIC": kinematic,
    "DISTRIBUTING": distributing,
    "DISTRIBUTING COUPLING": distributing_coupling,
    "RIGID BODY": rigid_body,
    "PRE-TENSION SECTION": pretension_section,
    "CONTACT PAIR": contact_pair,
    "SURFACE INTERACTION": surface_interaction,
    "FRICTION": friction,
    "SURFACE BEHAVIOR": surface_behavior,
    "MASS": mass,
    "SPRING": spring,
}
#: keywords that change a structure in ways that are not modelled, and what is said of them
REFUSED = {
    "SHELL SECTION": "shells are not read: solid elements alone are",
    "SHELL GENERAL SECTION": "shells are not read: solid elements alone are",
    "MEMBRANE SECTION": "membranes are not read: solid elements alone are",
    "BEAM GENERAL SECTION": "beams are not read, but those of bolts with *BEAM SECTION",
    "COHESIVE SECTION": "cohesive elements are not read",
    "GASKET SECTION": "gaskets are not read",
    "CONNECTOR SECTION": "connectors are not read",
    "CYCLIC SYMMETRY MODEL": "cyclic symmetry is not modelled",
    "SUBMODEL": "submodels are not read",
    "USER ELEMENT": "user elements are not read: give matrices, type: matrices",
    "UEL PROPERTY": "user elements are not read: give matrices, type: matrices",
    "MATRIX ASSEMBLE": "matrices are not read from decks: give them to type: matrices",
    "HYPERELASTIC": "materials are linear: *ELASTIC",
    "HYPERFOAM": "materials are linear: *ELASTIC",
    "USER MATERIAL": "materials are linear: *ELASTIC",
    "DASHPOT": "dashpots are not read: loss factor and damping are keys of the case",
    "GAP": "elements of gaps are not read: contact is that of surfaces",
    "MPC": "multi-point constraints are read from *EQUATION, *COUPLING and *TIE alone",
    "EMBEDDED ELEMENT": "embedded elements are not read",
    "SHELL TO SOLID COUPLING": "shells are not read: solid elements alone are",
    "FASTENER": "fasteners are not read: bolts are pre-tension sections or couplings",
    "MODEL CHANGE": "elements that come and go are not modelled",
    "NGEN": "nodes must be given by *NODE: they are not generated",
    "NFILL": "nodes must be given by *NODE: they are not generated",
    "NCOPY": "nodes must be given by *NODE: they are not generated",
    "NMAP": "nodes must be given by *NODE: they are not generated",
    "ELGEN": "elements must be given by *ELEMENT: they are not generated",
    "ELCOPY": "elements must be given by *ELEMENT: they are not generated",
    "CLEARANCE": "gaps are those of the surfaces",
}
