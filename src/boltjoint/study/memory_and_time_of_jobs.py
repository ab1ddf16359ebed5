"""Memory and time of the jobs of a study, from the sizes in its configuration alone.

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

from collections.abc import Iterator
from typing import NamedTuple

from boltjoint.config.conflicts_of_measured import fits_preloads, measurement_of
from boltjoint.config.described import COUNTLESS
from boltjoint.config.numerical_options import Solver
from boltjoint.config.study import Study
from boltjoint.config.sweep import LEVEL_KEYS
from boltjoint.config.types import (
    ASSEMBLY_FOLDER,
    CASE_FOLDER,
    CONFIG_FILE,
    SWEEP_FOLDER,
    refusing_exceptions,
)
from boltjoint.names import Basis, JointName
from boltjoint.options import CONVERGING
from boltjoint.study.artefact_list import Contents
from boltjoint.study.time_of_calibration import count_tightenings, time_of_calibration

_NUMBER = 8

#: Python with what the finite elements import, and with what the responses import and compile where
#: no process before has compiled it (else half of that) [byte]
_PROCESS, _SOLVER = 137e6, 510e6
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
#: numbers of each sample of each contact point and direction that AFT holds
_SAMPLED = 6
#: harmonics where a study leaves their number open
MOST_CHOSEN = CONVERGING[-1]
#: times the harmonics of a peak with which its truncation error is found, at most
LEFT_OUT = 3
#: most harmonics at the peaks that are integrated in time: of free modes, and of enriched bases
_MANY, MANY_ENRICHED = 201, 97
#: samples whose derivatives are transformed to harmonics at once
_SAMPLES_AT_ONCE = 64

#: time of the finite elements, of nodes^2 [s]; modes: for every fourth one
_TIGHTEN, _MODES, _PRINCIPAL, _PATTERNS = 1.3e-8, 0.9e-8, 8e-8, 3.2e-8
#: of a response with its figure and tables; and of a force level of it, of the pairs [s]
_PER_RESPONSE, _PER_LEVEL = 4.0, 8e-4
#: of a force at whose peak a joint is integrated in time, and balanced, of the pairs [s]
_PER_INTEGRATION = 0.03
#: samples that take as long as the closed form; the tangents of this many harmonics as the samples
_SAMPLES_AS_EXACT, _HARMONICS_AS_SAMPLES = 25, 10**0.5
#: of a design at a level, and of each element in each vector [s]
_PER_DESIGN, _PER_ELEMENT = 4e-3, 5e-6
#: of a peak with all harmonics, of each element, and of the cube of vectors and components [s]
_PER_CONVERGED, _PER_CONVERGED_ELEMENT, _PER_CUBE = 0.3, 8e-4, 5.5e-10
#: share of it without error bars, and of a design of which only peaks are kept
_WITHOUT_BARS, _OF_PEAKS = 0.2, 0.3
#: of the regression of peaks with all harmonics, by the cube of the designs that have them [s]
_PER_REGRESSION = 60.0 / 300**3
#: of the joints of a variant: node to node, divided and reduced [s]
_PER_JOINT = 12.0
#: of a design at an amplitude of the grid of backbones [s]
_PER_AMPLITUDE = 1e-3
#: solutions of a response with steps of the default length, and what holds them, over themselves
_SOLUTIONS, _COPIES = 330, 4
#: of an initial guess for an element of a region [s], and the numbers of each guess that are held
_PER_GUESS, _NUMBERS_OF_GUESS = 4e-3, 6
#: states of all resonances and adaptations from which contact-adapted bases are made by default,
#: and what is held of a state, over its candidates
_STATES, _VECTORS_OF_STATE = 24 * 6 * 2, 8
#: of the peaks of a joint in a basis that are compared with others; and divisions with as many
#: regions that are [s]
_PER_PEAKS, _DIVISIONS = 3.0, 5
#: regions with which a tolerance is met at most
_MOST_REGIONS = 64
#: of the list of designs, with their values and what is wrong with them [byte]
_PER_ROW = 1000


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


def all_jobs(contents: Contents) -> Iterator[EstimatedJob]:
    """Jobs of a study on its assemblies, cases and sweeps."""
    study = contents.study
    varied = (variant.assembly_name for variant in study.possible_variants())
    for folder, names in (
        (ASSEMBLY_FOLDER, dict.fromkeys([*study.assemblies, *varied])),
        (CASE_FOLDER, study.cases),
        (SWEEP_FOLDER, study.sweeps),
    ):
        for name in names:
            yield from _jobs_on(contents, folder, name)


def jobs_on(contents: Contents, name: str) -> Iterator[EstimatedJob]:
    """Jobs on what has this name: an assembly, a case, a sweep or several of them."""
    study = contents.study
    is_of_study = name in study.cases or name in study.sweeps
    # variants, which are made to be asked, have names of their own
    if name in study.assemblies or (
        not is_of_study and any(study.variants_of(ASSEMBLY_FOLDER, name))
    ):
        yield from _jobs_on(contents, ASSEMBLY_FOLDER, name)
    if name in study.cases:
        yield from _jobs_on(contents, CASE_FOLDER, name)
    if name in study.sweeps:
        yield from _jobs_on(contents, SWEEP_FOLDER, name)


def _jobs_on(contents: Contents, folder: str, name: str) -> Iterator[EstimatedJob]:
    of_folder = {ASSEMBLY_FOLDER: _of_assembly, CASE_FOLDER: _of_case, SWEEP_FOLDER: _of_sweep}
    with refusing_exceptions(f"{folder}/{name}.yaml", "estimated"):
        yield from of_folder[folder](contents, name)


def _of_assembly(contents: Contents, name: str) -> Iterator[EstimatedJob]:
    """Jobs on the finite elements."""
    study = contents.study
    assembly, file = study.assembly(name), f"{ASSEMBLY_FOLDER}/{name}.yaml"
    key = f"{file}: {'mesh' if assembly.HAS_MESH else 'its files'}"
    # what is told of half the nodes holds of all where nothing halves them
    whole = 1 if assembly.has_mirror_images else 2
    size = assembly.size
    nodes, pairs = (min(whole * factor, COUNTLESS) for factor in (size.nodes, size.pairs))
    vector, square, fill = _NUMBER * 3 * nodes, nodes**2, nodes ** (4 / 3)
    factors = _FACTORS_FREE * fill
    preloads = {factor.preload_N for factor in contents.select("preload", assembly=name)}
    modes = contents.select("modes", form="data", assembly=name)
    bases = {factor.basis for factor in modes if factor.basis is not None}
    varied = list(study.variants_of(ASSEMBLY_FOLDER, name))
    preloads |= {factor.case.preload for factor in varied}
    bases = bases.union(*(factor.bases for factor in varied))
    if not assembly.HAS_MESH:
        # rigid-body motions are sought with factors
        memory = _PROCESS + _BESIDE_FACTORS + factors
        yield EstimatedJob("build", name, memory, _MODES * square, key, "to read the structure")
    for _ in preloads:
        memory = _PROCESS + _BESIDE_FACTORS + _FACTORS * fill
        yield EstimatedJob("preload", name, memory, _TIGHTEN * square, key, "to tighten the bolts")
    for basis in sorted(bases):
        if basis.is_contact_adapted:
            continue
        number = basis.most
        # of three modes about one bends in the plane
        met = _VECTORS_PER_MODE * (3 * number + 2) * vector
        memory = _PROCESS + _BESIDE_FACTORS + factors + met
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
            _PROCESS
            + whole ** (4 / 3) * factors
            + _CANDIDATES * candidates * of_motion / 2
            + _SQUARES * _NUMBER * candidates**2
            + 3 * min(study.contact_adapted_basis.maximum_vectors, candidates) * of_motion
        )
        options = study.contact_adapted_basis
        states = options.states * options.resonances
        of_states = _NUMBER * _VECTORS_OF_STATE * states * candidates
        if of_states > memory:
            key = f"{CONFIG_FILE}: contact_adapted_basis.states"
        seconds = _PRINCIPAL * whole**2 * square * max(states * options.adaptations / _STATES, 1)
        does = "to find the vectors of contact-adapted bases"
        yield EstimatedJob("pod_modes", name, memory + of_states, seconds, key, does)
    if contents.select("patterns", form="data", assembly=name):
        memory = _PROCESS + factors
        yield EstimatedJob("patterns", name, memory, _PATTERNS * square, key, "to find resonances")


def _of_case(contents: Contents, name: str) -> Iterator[EstimatedJob]:
    """Jobs on the joints."""
    study = contents.study
    case, solver = study.cases[name], study.solver
    pairs = min(study.assembly(case.assembly).contact_pairs, COUNTLESS)
    most = MOST_CHOSEN if solver.harmonics == "auto" else solver.harmonics
    harmonics, samples = (int(min(n, COUNTLESS)) for n in (most, solver.time_samples))
    law = case.contact.declaration
    directions, components = len(law.directions), law.components_of(harmonics)
    effort, sampled = 1.0, 0.0
    if solver.sampling is not None:
        sampled = _NUMBER * _SAMPLED * samples * pairs * directions
        effort = samples / _SAMPLES_AS_EXACT * (1 + (harmonics / _HARMONICS_AS_SAMPLES) ** 2)
    factor, with_peaks = _solutions(solver) / _SOLUTIONS, set()
    for response in contents.responses(name):
        vectors = _vectors(study, response.basis)
        unknowns = components * (response.coordinates.count or vectors)
        memory = _SOLVER + _NUMBER * (
            _TANGENTS * pairs * (directions * components) ** 2 + _JACOBIANS * unknowns**2
        )
        key = f"{CONFIG_FILE}: solver.harmonics"
        if study.harmonic_convergence:
            of_peaks = _memory_of_balance(law.components_of(LEFT_OUT * MOST_CHOSEN), vectors)
            if of_peaks > memory:
                memory, key = of_peaks, f"{CONFIG_FILE}: converged_peaks"
        if sampled > memory:
            key = f"{CONFIG_FILE}: solver.time_samples"
        memory += sampled
        stored = _NUMBER * _COPIES * len(case.levels) * _solutions(solver) * unknowns
        if stored > memory:
            key = f"{CONFIG_FILE}: solver.largest_step"
        memory += stored
        of_level = _PER_LEVEL * effort * law.relative_time * pairs * factor
        of_joint = response.basis, response.joint, response.resonance
        if study.harmonic_convergence and of_joint not in with_peaks:
            with_peaks.add(of_joint)  # of all its responses
            of_motion = law.components_of(MOST_CHOSEN)
            of_level += _of_converged_peak(of_motion, _elements(response.joint, pairs), vectors)
        seconds, does = _PER_RESPONSE + of_level * len(case.levels), f"to solve responses of {name}"
        yield EstimatedJob("responses", name, memory, seconds, key, does, part=str(response.basis))
    for basis in case.bases:
        for joint in contents.fitted(name, basis):
            yield _of_fit(study, name, joint)._replace(part=f"{basis}/{joint}")
    if case.measured is not None:
        yield _of_calibration(contents, name, pairs)
    if contents.converged(name):
        of_basis = contents.compared_bases(name), contents.reduced(name)
        regions = study.convergence.regions
        compared = len(of_basis[0]) + len(of_basis[1]) + _DIVISIONS * len(regions)
        key = f"{CONFIG_FILE}: convergence"
        seconds = _PER_PEAKS * compared * factor
        yield EstimatedJob("divisions", name, _SOLVER, seconds, key, "to compare peaks")
    if integrated := contents.integrated(name):
        vectors = _vectors(study, integrated.basis)
        memory = _memory_of_balance(law.components_of(_MANY), vectors)
        seconds = _PER_INTEGRATION * len(case.verification_forces_N) * pairs
        key = f"{CASE_FOLDER}/{name}.yaml: the first basis free-N, with verification_forces_N"
        yield EstimatedJob("harmonics", name, memory, seconds, key, f"to balance {_MANY} harmonics")
    bases = contents.bases_of_integration(name)
    for stage, basis, many in zip(
        ("steady_states", "larger_basis"), bases, (MANY_ENRICHED, MOST_CHOSEN), strict=False
    ):
        vectors = _vectors(study, basis)
        memory = _memory_of_balance(law.components_of(many), vectors)
        seconds = _PER_INTEGRATION * len(contents.integrated_levels(name)) * pairs
        key = f"{CONFIG_FILE}: convergence.time_integration_N"
        yield EstimatedJob(stage, name, memory, seconds, key, f"to balance {many} harmonics")


def _of_calibration(contents: Contents, name: str, pairs: float) -> EstimatedJob:
    """The fit of a joint to its measurement, and of preloads of its bolts."""
    study, case = contents.study, contents.study.cases[name]
    measured, basis = measurement_of(case), contents.calibrated(name)["basis"]
    elements, vectors = _elements(measured.joint, pairs), _vectors(study, basis)
    effort = case.contact.declaration.relative_time * elements * vectors
    seconds = time_of_calibration(measured, effort, *study.measured_points.get(name, (1, 0)))
    memory, key = _SOLVER, f"{CASE_FOLDER}/{name}.yaml: measured.starts"
    if fits_preloads(measured):
        assembly = study.assembly(case.assembly)
        nodes = min((2 - assembly.has_mirror_images) * assembly.size.nodes, COUNTLESS)
        memory = max(memory, _PROCESS + _BESIDE_FACTORS + _FACTORS * nodes ** (4 / 3))
        seconds += _TIGHTEN * nodes**2 * count_tightenings(measured, assembly.bolt_count)
    return EstimatedJob("calibration", name, memory, seconds, key, f"to fit {name}")


def _solutions(solver: Solver) -> float:
    """Solutions of a branch: as many as its steps ask for, up to the limit."""
    of_steps = _SOLUTIONS * Solver.model_fields["largest_step"].default / solver.largest_step
    return max(min(of_steps, solver.maximum_solutions), _SOLUTIONS)


def _of_fit(study: Study, subject: str, joint: JointName) -> EstimatedJob:
    """The fit of the elements of a joint."""
    guesses = study.fitting.initial_guesses
    regions = joint.count if isinstance(joint.count, int) else _MOST_REGIONS
    elements = joint.elements or 1
    memory = _PROCESS + _NUMBER * _NUMBERS_OF_GUESS * guesses * elements
    seconds = _PER_GUESS * guesses * regions * elements
    key = f"{CONFIG_FILE}: fitting.initial_guesses"
    return EstimatedJob("fit", subject, memory, seconds, key, f"to fit {joint}")


def _memory_of_balance(components: int, modes: int) -> float:
    """Of a balance with many harmonics in linear modes [byte]."""
    at_once = max(_SAMPLES_AT_ONCE, components) * components * modes**2
    return _SOLVER + _NUMBER * (at_once + (1 + _JACOBIANS) * (components * modes) ** 2)


def _of_sweep(contents: Contents, name: str) -> Iterator[EstimatedJob]:
    """Jobs on the joints and the designs of a sweep."""
    study = contents.study
    sweep, designs = study.sweeps[name], study.swept[name].number
    variants = study.swept[name].possible_variants
    key = f"{SWEEP_FOLDER}/{name}.yaml: design"
    joints = {(variant.case_name, variant.joint) for variant in variants}
    yield EstimatedJob("joints", name, _PROCESS, _PER_JOINT * len(joints), key, "to reduce a joint")
    for case_name, joint in joints:
        if joint.is_fitted:
            yield _of_fit(study, case_name, joint)
    case = study.case(sweep.case)
    levels = 1 if LEVEL_KEYS & set(sweep.vary) else len(sweep.levels or case.levels)
    elements = max(_elements(variant.joint, variant.assembly.contact_pairs) for variant in variants)
    vectors = _vectors(study, sweep.basis)
    states = elements if "contact-states" in sweep.observe else 0
    frequencies, amplitudes = (sweep.observed[key] or 0 for key in ("frequencies", "amplitudes"))
    stored = levels * (_NUMBER * (4 + frequencies) + states) + 2 * _NUMBER * amplitudes
    seconds = levels * (_PER_DESIGN + _PER_ELEMENT * elements * vectors)
    seconds *= 1.0 if "responses" in sweep.observe else _OF_PEAKS
    seconds = seconds * _solutions(study.solver) / _SOLUTIONS + _PER_AMPLITUDE * amplitudes
    law, of_peaks = case.contact.declaration, 0.0
    beyond, of_peak = (LEFT_OUT, 1.0) if sweep.error_bars else (1, _WITHOUT_BARS)
    if "converged-peaks" in sweep.observe:
        numbers = sweep.designs_by_harmonics or {sweep.harmonics: designs}
        many = law.components_of(beyond * min(sweep.harmonics, MOST_CHOSEN))
        of_peaks = _memory_of_balance(many, vectors) - _SOLVER
        stored += levels * _NUMBER * (5 + 2 * len(sweep.designs_by_harmonics or {}))
        for highest, number in numbers.items():
            components = law.components_of(min(highest, MOST_CHOSEN))
            converged = of_peak * _of_converged_peak(components, elements, vectors)
            seconds += levels * min(number / designs, 1.0) * converged
    multiples = {"design": designs, "frequencies": frequencies, "amplitudes": amplitudes}
    key = f"{SWEEP_FOLDER}/{name}.yaml: {max(multiples, key=lambda key: multiples[key])}"
    chunk = min(sweep.designs_per_job, designs)
    memory = _SOLVER + of_peaks + 2 * chunk * stored + _PER_ROW * designs
    does = f"to solve designs of {name}"
    jobs = contents.chunks(name)
    yield EstimatedJob("designs", name, memory, designs * seconds, key, does, parts=jobs)
    memory = _PROCESS + 3 * designs * stored + _PER_ROW * designs
    solved = [min(number, designs) for number in (sweep.designs_by_harmonics or {}).values()]
    seconds = levels * _PER_REGRESSION * sum(number**3 for number in solved)
    yield EstimatedJob("sweep", name, memory, seconds, key, f"to gather the designs of {name}")
    if sweep.check is not None:
        check = sweep.check
        elements = max(_elements(check.joint, each.assembly.contact_pairs) for each in variants)
        vectors = _vectors(study, check.basis)
        number = min(check.designs, designs)
        of_design = _PER_DESIGN + _PER_ELEMENT * elements * vectors
        highest = min(check.harmonics, MOST_CHOSEN)
        converged = _of_converged_peak(law.components_of(highest), elements, vectors)
        of_design += of_peak * converged
        seconds = _PER_JOINT * len(variants) + number * levels * of_design
        many = law.components_of(beyond * highest)
        memory = _memory_of_balance(many, vectors) + _PER_ROW * designs
        key = f"{SWEEP_FOLDER}/{name}.yaml: check.designs"
        yield EstimatedJob("sweep_check", name, memory, seconds, key, f"to check designs of {name}")


def _vectors(study: Study, basis: Basis) -> int:
    """Vectors of a basis, at most."""
    if not basis.is_contact_adapted:
        return basis.most
    return min(basis.most, study.contact_adapted_basis.maximum_vectors)


def _of_converged_peak(components: int, elements: float, vectors: int) -> float:
    """Time of a peak with so many components of its motion [s]."""
    of_factors = _PER_CUBE * (vectors * components) ** 3
    return _PER_CONVERGED + _PER_CONVERGED_ELEMENT * elements + of_factors


def _elements(joint: JointName, pairs: float) -> float:
    """Elements of a joint, at most: of tolerances nothing is known yet."""
    if isinstance(joint.pairs, int):
        return joint.pairs
    if joint.reduction is None or not isinstance(joint.count, int):
        return pairs
    return joint.count * (joint.elements or 1)
