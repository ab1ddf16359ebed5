"""Memory and time that a study needs, from the sizes in its configuration alone.

Nothing is built: a mesh that no machine can hold is counted in no time. The constants are fitted to
peaks of memory measured on one machine (``benchmarks/memory.py``; four_bolt took no part in it):

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

Memory is right within an eighth there, within a third for many modes, and within a factor of two
for the responses. Time is right within a factor of two for the finite elements, and of three for a
study on a machine that does nothing else.
"""

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from boltjoint.config.study import Study
from boltjoint.config.sweep import LEVEL_KEYS
from boltjoint.config.types import (
    ASSEMBLY_FOLDER,
    CASE_FOLDER,
    CONFIG_FILE,
    SWEEP_FOLDER,
    refusing_exceptions,
)
from boltjoint.names import JointName
from boltjoint.structure.bolts import yield_warning
from boltjoint.study.artefact_list import Contents
from boltjoint.study.mesh_size import COUNTLESS, mesh_size

_GIB = 2**30
_NUMBER = 8

#: Python with what the finite elements import, and with what the responses import and compile where
#: no process before has compiled it (else half of that) [byte]
_PROCESS, _SOLVER = 137e6, 510e6
#: the two Snakemakes that start a job on a node of a cluster [byte]
_SNAKEMAKE = 290e6
#: factors of the stiffness of one half of all nodes, with contact and without: these times
#: nodes^(4/3), the fill of a body in space; and what else tightening or a search for modes holds
#: [byte]
_FACTORS, _FACTORS_FREE, _BESIDE_FACTORS = 650, 600, 1.1e8
#: vectors of all displacements that a search for modes holds for each mode it meets
_VECTORS_PER_MODE = 6
#: what is as large as the candidates of enriched bases, over them, and their square matrices
_CANDIDATES, _SQUARES = 1.3, 14
#: tangents of the contact points, and Jacobians, that a correction of the balance holds
_TANGENTS, _JACOBIANS = 3, 4
#: harmonics where a study leaves their number open
_MOST_CHOSEN = 33
#: most harmonics at the peaks that are integrated in time: of free modes, and of enriched bases
_MANY, _MANY_ENRICHED = 201, 97
#: samples whose derivatives are transformed to harmonics at once
_SAMPLES_AT_ONCE = 64

#: time of the finite elements, of nodes^2 [s]; modes: for every fourth one
_TIGHTEN, _MODES, _PRINCIPAL, _PATTERNS = 1.3e-8, 0.9e-8, 8e-8, 3.2e-8
#: of a response with its timing, check, figure and tables; and of a force level of it, of the
#: pairs [s]
_PER_RESPONSE, _PER_LEVEL = 12.0, 3.5e-3
#: of a force at whose peak a joint is integrated in time and balanced with many harmonics, of the
#: pairs [s]
_PER_INTEGRATION = 0.03
#: samples that take as long as the closed form; the tangents of this many harmonics as the samples
_SAMPLES_AS_EXACT, _HARMONICS_AS_SAMPLES = 25, 10**0.5
#: of a design at a level, and of each element in each vector [s]
_PER_DESIGN, _PER_ELEMENT = 4e-3, 5e-6
#: of the joints of a variant: node to node, divided and reduced [s]
_PER_JOINT = 12.0
#: of the list of designs, with their values and what is wrong with them [byte]
_PER_ROW = 1000


@dataclass(frozen=True)
class Estimate:
    """What a study needs.

    Attributes
    ----------
    memory
        Of the job that needs most [byte].
    key
        File and key by which that job is made smaller.
    job
        What that job does.
    seconds
        Of one core [s], for the finite elements, the responses and the time integration; fits,
        peaks with more harmonics and the tables of ``convergence`` come on top.
    responses
        Frequency responses.
    designs
        Designs of sweeps.
    meshes, tightenings, joints
        Of sweeps: assemblies that are meshed, rows of bolts that are tightened, and joints that are
        made.
    """

    memory: float
    key: str
    job: str
    seconds: float
    responses: int
    designs: int
    meshes: int
    tightenings: int
    joints: int


class _Job(NamedTuple):
    stage: str
    subject: str
    memory: float
    seconds: float
    key: str
    does: str
    #: jobs among which the time is divided
    parts: int = 1


def estimate(study: Study) -> Estimate:
    """What a study needs: memory of its largest job, and time of all jobs.

    Raises
    ------
    ConfigError
        If the values of a file cannot be estimated.
    """
    with refusing_exceptions(CONFIG_FILE, "planned"):
        contents = Contents(study)
    jobs, variants = list(_jobs(contents)), study.possible_variants()
    largest = max(jobs, key=lambda job: job.memory)
    return Estimate(
        memory=largest.memory,
        key=largest.key,
        job=largest.does,
        seconds=sum(job.seconds for job in jobs),
        responses=sum(len(case.responses) for case in study.cases.values()),
        designs=sum(study.designs.values()),
        meshes=len({each.assembly_name for each in variants}),
        tightenings=len({(each.assembly_name, each.case.preload) for each in variants}),
        joints=len({(each.case_name, each.joint) for each in variants}),
    )


def machine_memory() -> float:
    """Memory of this machine, or what its control group (cgroup v2) may have of it [byte]."""
    memory = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    limit = Path("/sys/fs/cgroup/memory.max")
    if limit.is_file() and (text := limit.read_text().strip()) != "max":
        memory = min(memory, float(text))
    return memory


def shortage(needed: Estimate, memory: float | None) -> str | None:
    """A line that says which key asks for more memory than there is [byte]; None if none does.

    What is there is None on a cluster, which knows its nodes itself.
    """
    if memory is None or needed.memory <= memory:
        return None
    return (
        f"{needed.key}: needs some {needed.memory / _GIB:.3g} GiB of memory {needed.job}, and this "
        f"machine has {memory / _GIB:.3g} GiB: must be smaller"
    )


def summary(needed: Estimate, memory: float | None, cores: int | None) -> str:
    """A line on what a study needs beside what there is: memory [byte] and cores of this machine.

    Both are None where jobs go to a cluster.
    """
    minutes = needed.seconds / (cores or 1) / 60
    time = f"{minutes:.0f} minutes" if minutes < 100 else f"{minutes / 60:.0f} hours"
    solved = f"{needed.responses} frequency responses"
    if needed.designs:
        solved += f" and {needed.designs} designs"
        if needed.joints > 1:
            solved += (
                f" with {needed.joints} joints ({needed.meshes} meshes, "
                f"{needed.tightenings} tightenings of bolts)"
            )
    where = "of one core" if cores is None else f"on {cores} core{'s'[: cores - 1]}"
    line = (
        f"Estimate: {solved} in some {time} {where} if "
        f"nothing of it is there yet; up to {needed.memory / _GIB:.2g} GiB of memory a job "
        f"({needed.job})"
    )
    return line if memory is None else f"{line}, of {memory / _GIB:.3g} GiB"


def overstrained(study: Study) -> list[str]:
    """A line for each preload that strains the shanks of an assembly beyond yield."""
    given = [
        (f"{CASE_FOLDER}/{name}.yaml", study.assemblies[case.assembly], case.preload_N)
        for name, case in study.cases.items()
    ]
    used = {case.assembly for case in study.cases.values()}
    given += [
        (f"{ASSEMBLY_FOLDER}/{name}.yaml", found, found.preload_N)
        for name, found in study.assemblies.items()
        if name not in used and found.preload_N is not None
    ]
    lines = []
    for file, found, preload in given:
        area = math.pi / 4 * (1e-3 * found.bolts.shank_diameter_mm) ** 2
        if sentence := yield_warning(preload, area, 1e9 * found.bolt_material.youngs_modulus_GPa):
            lines.append(f"{file}: preload_N: {sentence}")
    return lines


class Resources:
    """What the jobs of each stage need, as Snakemake is told: ``mem_mb`` and ``runtime`` [min].

    A cluster ends a job that takes more, so there is room: half as much memory again as estimated,
    with that of the processes of Snakemake, and a machine of a third the speed.
    """

    #: of jobs that only read, tabulate or draw: measured for figures
    SMALL = MappingProxyType({"mem_mb": math.ceil((510e6 + _SNAKEMAKE) / 1e6), "runtime": 10})

    def __init__(self, study: Study) -> None:
        self._contents = Contents(study)
        # a job asks for few of them
        self._jobs = cache(lambda subject: list(_of_subject(self._contents, subject)))

    def of(self, stage: str, subject: str) -> Mapping[str, int]:
        """Those of a stage of an assembly, case or sweep."""
        jobs = [job for job in self._jobs(subject) if job.stage == stage] if stage else []
        if not jobs:
            return self.SMALL
        return {
            "mem_mb": math.ceil((1.5 * max(job.memory for job in jobs) + _SNAKEMAKE) / 1e6),
            "runtime": math.ceil(10 + 3 * sum(job.seconds / job.parts for job in jobs) / 60),
        }

    def of_any(self, stage: str) -> Mapping[str, int]:
        """The largest of a stage of any sweep."""
        found = [self.of(stage, sweep) for sweep in self._contents.study.sweeps] or [self.SMALL]
        return {key: max(each[key] for each in found) for key in self.SMALL}


def _jobs(contents: Contents) -> Iterator[_Job]:
    study = contents.study
    varied = (each.assembly_name for each in study.possible_variants())
    for name in dict.fromkeys([*study.assemblies, *varied, *study.cases, *study.sweeps]):
        yield from _of_subject(contents, name)


def _of_subject(contents: Contents, name: str) -> Iterator[_Job]:
    """Jobs on what has this name: an assembly, a case, a sweep or several of them."""
    study = contents.study
    # variants, which are made to be asked, have names of their own
    known = name in study.cases or name in study.sweeps
    is_varied = not known and any(study.variants_of(ASSEMBLY_FOLDER, name))
    for folder, jobs_of, is_there in (
        (ASSEMBLY_FOLDER, _of_assembly, name in study.assemblies or is_varied),
        (CASE_FOLDER, _of_case, name in study.cases),
        (SWEEP_FOLDER, _of_sweep, name in study.sweeps),
    ):
        if is_there:
            with refusing_exceptions(f"{folder}/{name}.yaml", "estimated"):
                yield from jobs_of(contents, name)


def _of_assembly(contents: Contents, name: str) -> Iterator[_Job]:
    """Jobs on the finite elements."""
    study = contents.study
    size, key = mesh_size(study.assembly(name)), f"{ASSEMBLY_FOLDER}/{name}.yaml: mesh"
    nodes = min(size.nodes, COUNTLESS)
    vector, square, fill = _NUMBER * 3 * nodes, nodes**2, nodes ** (4 / 3)
    factors = _FACTORS_FREE * fill
    preloads = {each.preload_N for each in contents.select("preload", assembly=name)}
    bases = {each.basis for each in contents.select("modes", form="data", assembly=name)}
    varied = list(study.variants_of(ASSEMBLY_FOLDER, name))
    preloads |= {each.case.preload for each in varied}
    bases |= {each.basis for each in varied}
    for _ in preloads:
        memory = _PROCESS + _BESIDE_FACTORS + _FACTORS * fill
        yield _Job("preload", name, memory, _TIGHTEN * square, key, "to tighten the bolts")
    for basis in sorted(bases):
        if basis.is_contact_adapted:
            continue
        number = basis.vectors
        # of three modes about one bends in the plane
        met = _VECTORS_PER_MODE * (3 * number + 2) * vector
        memory = _PROCESS + _BESIDE_FACTORS + factors + met
        seconds = _MODES * square * max(number / 4, 1)
        yield _Job(str(basis), name, memory, seconds, key, f"to find {number} modes")
    if any(basis.is_contact_adapted for basis in bases):
        # pairs of one half of the width, along x and z
        candidates = min(size.pairs + study.contact_adapted_basis.free_modes, COUNTLESS)
        memory = (
            _PROCESS
            + factors
            + _CANDIDATES * candidates * vector / 2
            + _SQUARES * _NUMBER * candidates**2
            + 3 * min(study.contact_adapted_basis.maximum_vectors, candidates) * vector
        )
        does = "to find the vectors of contact-adapted bases"
        yield _Job("pod_modes", name, memory, _PRINCIPAL * square, key, does)
    if contents.select("patterns", form="data", assembly=name):
        memory = _PROCESS + factors
        yield _Job("patterns", name, memory, _PATTERNS * square, key, "to find resonances")


def _of_case(contents: Contents, name: str) -> Iterator[_Job]:
    """Jobs on the joints."""
    study = contents.study
    case, solver = study.cases[name], study.solver
    pairs = min(study.assembly(case.assembly).contact_pairs, COUNTLESS)
    most = _MOST_CHOSEN if solver.harmonics == "auto" else solver.harmonics
    harmonics, samples = (min(n, COUNTLESS) for n in (most, solver.time_samples))
    law = case.contact.declaration
    directions, components = len(law.directions), law.components_of(harmonics)
    effort = 1.0
    if solver.sampling is not None:
        effort = samples / _SAMPLES_AS_EXACT * (1 + (harmonics / _HARMONICS_AS_SAMPLES) ** 2)
    for response in contents.responses(name):
        vectors = min(response.basis.most, study.contact_adapted_basis.maximum_vectors)
        if not response.basis.is_contact_adapted:
            vectors = response.basis.vectors
        unknowns = components * (response.coordinates.count or vectors)
        memory = _SOLVER + _NUMBER * (
            _TANGENTS * pairs * (directions * components) ** 2 + _JACOBIANS * unknowns**2
        )
        if study.harmonic_convergence:
            of_peaks = _memory_of_balance(law.components_of(_MOST_CHOSEN), vectors)
            memory = max(memory, of_peaks)
        effort_of_law = effort * law.relative_time
        seconds = _PER_RESPONSE + _PER_LEVEL * effort_of_law * len(case.levels) * pairs
        key = f"{CONFIG_FILE}: solver.harmonics"
        yield _Job("responses", name, memory, seconds, key, f"to solve responses of {name}")
    if response := contents.integrated(name):
        memory = _memory_of_balance(law.components_of(_MANY), response.basis.vectors)
        seconds = _PER_INTEGRATION * len(case.verification_forces_N) * pairs
        key = f"{CASE_FOLDER}/{name}.yaml: the first basis free-N, with verification_forces_N"
        yield _Job("harmonics", name, memory, seconds, key, f"to balance {_MANY} harmonics")
    bases = contents.bases_of_integration(name)
    for stage, basis, many in zip(
        ("steady_states", "larger_basis"), bases, (_MANY_ENRICHED, _MOST_CHOSEN), strict=False
    ):
        vectors = min(basis.most, study.contact_adapted_basis.maximum_vectors)
        memory = _memory_of_balance(law.components_of(many), vectors)
        seconds = _PER_INTEGRATION * len(contents.integrated_levels(name)) * pairs
        key = f"{CONFIG_FILE}: convergence.time_integration_N"
        yield _Job(stage, name, memory, seconds, key, f"to balance {many} harmonics")


def _memory_of_balance(components: int, modes: int) -> float:
    """Of a balance with many harmonics in linear modes [byte]."""
    at_once = _SAMPLES_AT_ONCE * components * modes**2
    return _SOLVER + _NUMBER * (at_once + (1 + _JACOBIANS) * (components * modes) ** 2)


def _of_sweep(contents: Contents, name: str) -> Iterator[_Job]:
    """Jobs on the joints and the designs of a sweep."""
    study = contents.study
    sweep, designs = study.sweeps[name], study.swept[name].number
    variants = study.swept[name].possible_variants
    key = f"{SWEEP_FOLDER}/{name}.yaml: design"
    joints = {(each.case_name, each.joint) for each in variants}
    yield _Job("joints", name, _PROCESS, _PER_JOINT * len(joints), key, "to reduce a joint")
    case = study.case(sweep.case)
    levels = 1 if LEVEL_KEYS & set(sweep.vary) else len(sweep.levels or case.levels)
    elements = max(_elements(each.joint, each.assembly.contact_pairs) for each in variants)
    vectors = min(sweep.basis.most, study.contact_adapted_basis.maximum_vectors)
    states = elements if "contact-states" in sweep.observe else 0
    stored = levels * (_NUMBER * (4 + (sweep.observed["frequencies"] or 0)) + states)
    seconds = levels * (_PER_DESIGN + _PER_ELEMENT * elements * vectors)
    chunk = min(sweep.designs_per_job, designs)
    memory = _SOLVER + 2 * chunk * stored + _PER_ROW * designs
    does = f"to solve designs of {name}"
    jobs = contents.chunks(name)
    yield _Job("designs", name, memory, designs * seconds, key, does, parts=jobs)
    memory = _PROCESS + 3 * designs * stored + _PER_ROW * designs
    yield _Job("sweep", name, memory, 0.0, key, f"to gather the designs of {name}")


def _elements(joint: JointName, pairs: float) -> float:
    """Elements of a joint, at most: of tolerances nothing is known yet."""
    if isinstance(joint.pairs, int):
        return joint.pairs
    if joint.reduction is None or joint.count == "auto":
        return pairs
    return joint.count * (joint.elements or 1)
