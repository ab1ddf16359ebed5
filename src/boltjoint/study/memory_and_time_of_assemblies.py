"""Memory and time of the jobs on the finite elements of an assembly.

Like those of other jobs (``memory_and_time_of_jobs``) they follow from the sizes in the
configuration alone. The constants are fitted to peaks of memory measured on one machine
(``benchmarks/memory.py``; four_bolt took no part in it):

==============  =====  ===================  ==================  ===================
GiB measured,   nodes  tightening of the    free-4              vectors of enriched
GiB estimated          bolts                                    bases
==============  =====  ===================  ==================  ===================
coarse           6952  0.33, 0.31           0.34, 0.32          0.31, 0.31
medium          14790  0.47, 0.45           0.51, 0.46          0.61, 0.64
``three_bolt``  30706  0.75, 0.81           0.85, 0.83          1.66, 1.65
``four_bolt``   39916  0.94, 1.06           1.05, 1.07          2.42, 2.40
fine            59520  1.66, 1.64           1.50, 1.64          4.45, 4.43
==============  =====  ===================  ==================  ===================

Memory is right within an eighth there, and within a third for many modes; time is right within a
factor of two.
"""

from collections.abc import Iterator
from typing import NamedTuple

from boltjoint.config.described import COUNTLESS
from boltjoint.config.types import ASSEMBLY_FOLDER, CONFIG_FILE
from boltjoint.study.artefact_list import Contents

#: of a floating-point number, and of Python with what the finite elements import [byte]
NUMBER, PROCESS = 8, 137e6
#: factors of the stiffness of one half of all nodes, with contact and without: these times
#: nodes^(4/3), the fill of a body in space; and what else tightening or a search for modes holds
#: [byte]
_FACTORS, _FACTORS_FREE, _BESIDE_FACTORS = 650, 600, 1.1e8
#: vectors of all displacements that a search for modes holds for each mode it meets
_VECTORS_PER_MODE = 6
#: what is as large as the candidates of enriched bases, over them, and their square matrices
_CANDIDATES, _SQUARES = 1.3, 14
#: time of the finite elements, of nodes^2 [s]; modes: for every fourth one
_TIGHTEN, _MODES, _PRINCIPAL, _PATTERNS = 1.3e-8, 0.9e-8, 8e-8, 3.2e-8
#: states of all resonances and adaptations from which contact-adapted bases are made by default,
#: and what is held of a state, over its candidates
_STATES, _VECTORS_OF_STATE = 24 * 6 * 2, 8


class EstimatedJob(NamedTuple):
    """A job, or several alike, with what it needs."""

    stage: str
    subject: str
    memory: float
    seconds: float
    key: str
    does: str
    #: jobs among which the time is divided; and what of the subject they are on, basis or joint
    parts: int = 1
    part: str = ""


def of_assembly(contents: Contents, name: str) -> Iterator[EstimatedJob]:
    """Jobs on the finite elements."""
    study = contents.study
    assembly, file = study.assembly(name), f"{ASSEMBLY_FOLDER}/{name}.yaml"
    key = f"{file}: {'mesh' if assembly.HAS_MESH else 'its files'}"
    # what is told of half the nodes holds of all where nothing halves them
    whole = 1 if assembly.has_mirror_images else 2
    size = assembly.size
    nodes, pairs = (min(whole * factor, COUNTLESS) for factor in (size.nodes, size.pairs))
    vector, square = NUMBER * 3 * nodes, nodes**2
    factors = _FACTORS_FREE * nodes ** (4 / 3)
    preloads = {factor.preload_N for factor in contents.select("preload", assembly=name)}
    modes = contents.select("modes", form="data", assembly=name)
    bases = {factor.basis for factor in modes if factor.basis is not None}
    varied = list(study.variants_of(ASSEMBLY_FOLDER, name))
    preloads |= {factor.case.preload for factor in varied}
    bases = bases.union(*(factor.bases for factor in varied))
    if not assembly.HAS_MESH:
        # rigid-body motions are sought with factors
        memory = PROCESS + _BESIDE_FACTORS + factors
        yield EstimatedJob("build", name, memory, _MODES * square, key, "to read the structure")
    for _ in preloads:
        memory, seconds = of_tightening(nodes)
        yield EstimatedJob("preload", name, memory, seconds, key, "to tighten the bolts")
    for basis in sorted(bases):
        if basis.is_contact_adapted:
            continue
        number = basis.most
        # of three modes about one bends in the plane
        met = _VECTORS_PER_MODE * (3 * number + 2) * vector
        memory = PROCESS + _BESIDE_FACTORS + factors + met
        seconds = _MODES * square * max(number / 4, 1)
        yield EstimatedJob(str(basis), name, memory, seconds, key, f"to find {number} modes")
    if any(basis.is_contact_adapted for basis in bases):
        # pairs of one half of the width, along x and z; with friction along both tangents all
        # pairs, in three directions
        laws = [case.contact.declaration for case in study.cases.values() if case.assembly == name]
        is_lateral = any("lateral" in law.directions for law in laws)
        whole = 2 if is_lateral and assembly.has_mirror_images else 1
        of_motion = whole * vector
        columns = whole * pairs * (1.5 if is_lateral else 1)
        candidates = min(columns + study.contact_adapted_basis.free_modes, COUNTLESS)
        memory = (
            PROCESS
            + whole ** (4 / 3) * factors
            + _CANDIDATES * candidates * of_motion / 2
            + _SQUARES * NUMBER * candidates**2
            + 3 * min(study.contact_adapted_basis.maximum_vectors, candidates) * of_motion
        )
        options = study.contact_adapted_basis
        states = options.states * options.resonances
        of_states = NUMBER * _VECTORS_OF_STATE * states * candidates
        if of_states > memory:
            key = f"{CONFIG_FILE}: contact_adapted_basis.states"
        seconds = _PRINCIPAL * whole**2 * square * max(states * options.adaptations / _STATES, 1)
        does = "to find the vectors of contact-adapted bases"
        yield EstimatedJob("pod_modes", name, memory + of_states, seconds, key, does)
    if contents.select("patterns", form="data", assembly=name):
        memory = PROCESS + factors
        yield EstimatedJob("patterns", name, memory, _PATTERNS * square, key, "to find resonances")


def of_tightening(nodes: float) -> tuple[float, float]:
    """Memory [byte] and time [s] to tighten the bolts of so many nodes."""
    return PROCESS + _BESIDE_FACTORS + _FACTORS * nodes ** (4 / 3), _TIGHTEN * nodes**2
