"""Memory and time of the jobs of a study, from the sizes in its configuration alone.

Nothing is built: a mesh that no machine can hold is counted in no time. Memory of the responses is
right within a factor of two, time within one of three for a study on a machine that does nothing
else; those of the finite elements are nearer (``memory_and_time_of_assemblies``).
"""

from collections.abc import Iterator

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
from boltjoint.study.memory_and_time_of_assemblies import (
    NUMBER,
    PROCESS,
    EstimatedJob,
    of_assembly,
    of_tightening,
)
from boltjoint.study.time_of_calibration import count_tightenings, time_of_calibration

#: Python with what the responses import and compile where no process before has compiled it (else
#: half of that) [byte]
_SOLVER = 510e6
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
#: of weights of pairs for the base case and eight designs, of each pair in each vector [s]
_PER_WEIGHTS = 5.5e-4
#: of a design at an amplitude of the grid of backbones [s]
_PER_AMPLITUDE = 1e-3
#: solutions of a response with steps of the default length, and what holds them, over themselves
_SOLUTIONS, _COPIES = 330, 4
#: of an initial guess for an element of a region [s], and the numbers of each guess that are held
_PER_GUESS, _NUMBERS_OF_GUESS = 4e-3, 6
#: of the peaks of a joint in a basis that are compared with others; and divisions with as many
#: regions that are [s]
_PER_PEAKS, _DIVISIONS = 3.0, 5
#: regions with which a tolerance is met at most
_MOST_REGIONS = 64
#: of the list of designs, with their values and what is wrong with them [byte]
_PER_ROW = 1000


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
    of_folder = {ASSEMBLY_FOLDER: of_assembly, CASE_FOLDER: _of_case, SWEEP_FOLDER: _of_sweep}
    with refusing_exceptions(f"{folder}/{name}.yaml", "estimated"):
        yield from of_folder[folder](contents, name)


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
        sampled = NUMBER * _SAMPLED * samples * pairs * directions
        effort = samples / _SAMPLES_AS_EXACT * (1 + (harmonics / _HARMONICS_AS_SAMPLES) ** 2)
    factor, with_peaks = _solutions(solver) / _SOLUTIONS, set()
    for response in contents.responses(name):
        vectors = _vectors(study, response.basis)
        unknowns = components * (response.coordinates.count or vectors)
        memory = _SOLVER + NUMBER * (
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
        stored = NUMBER * _COPIES * len(case.levels) * _solutions(solver) * unknowns
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
        of_one = of_tightening(nodes)
        memory = max(memory, of_one[0])
        seconds += of_one[1] * count_tightenings(measured, assembly.bolt_count)
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
    memory = PROCESS + NUMBER * _NUMBERS_OF_GUESS * guesses * elements
    seconds = _PER_GUESS * guesses * regions * elements
    key = f"{CONFIG_FILE}: fitting.initial_guesses"
    return EstimatedJob("fit", subject, memory, seconds, key, f"to fit {joint}")


def _memory_of_balance(components: int, modes: int) -> float:
    """Of a balance with many harmonics in linear modes [byte]."""
    at_once = max(_SAMPLES_AT_ONCE, components) * components * modes**2
    return _SOLVER + NUMBER * (at_once + (1 + _JACOBIANS) * (components * modes) ** 2)


def _of_sweep(contents: Contents, name: str) -> Iterator[EstimatedJob]:
    """Jobs on the joints and the designs of a sweep."""
    study = contents.study
    sweep, designs = study.sweeps[name], study.swept[name].number
    variants = study.swept[name].possible_variants
    key = f"{SWEEP_FOLDER}/{name}.yaml: design"
    joints = {(variant.case_name, variant.joint) for variant in variants}
    yield EstimatedJob("joints", name, PROCESS, _PER_JOINT * len(joints), key, "to reduce a joint")
    for case_name, joint in joints:
        if joint.is_fitted:
            yield _of_fit(study, case_name, joint)
    case = study.case(sweep.case)
    levels = 1 if LEVEL_KEYS & set(sweep.vary) else len(sweep.levels or case.levels)
    elements = max(_elements(variant.joint, variant.assembly.contact_pairs) for variant in variants)
    vectors = _vectors(study, sweep.basis)
    states = elements if "contact-states" in sweep.observe else 0
    frequencies, amplitudes = (sweep.observed[key] or 0 for key in ("frequencies", "amplitudes"))
    stored = levels * (NUMBER * (4 + frequencies) + states) + 2 * NUMBER * amplitudes
    seconds = levels * (_PER_DESIGN + _PER_ELEMENT * elements * vectors)
    seconds *= 1.0 if "responses" in sweep.observe else _OF_PEAKS
    seconds = seconds * _solutions(study.solver) / _SOLUTIONS + _PER_AMPLITUDE * amplitudes
    law, of_peaks = case.contact.declaration, 0.0
    beyond, of_peak = (LEFT_OUT, 1.0) if sweep.error_bars else (1, _WITHOUT_BARS)
    if "converged-peaks" in sweep.observe:
        numbers = sweep.designs_by_harmonics or {sweep.harmonics: designs}
        many = law.components_of(beyond * min(sweep.harmonics, MOST_CHOSEN))
        of_peaks = _memory_of_balance(many, vectors) - _SOLVER
        stored += levels * NUMBER * (5 + 2 * len(sweep.designs_by_harmonics or {}))
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
    pairs = max(variant.assembly.contact_pairs for variant in variants)
    for basis in contents.bases_of_weights(name):
        # whatever their number, they are found among all pairs
        memory = _SOLVER + NUMBER * pairs**2 + _PER_ROW * designs
        seconds = _PER_WEIGHTS * pairs * _vectors(study, basis)
        does = f"to weigh contact pairs for {name}"
        yield EstimatedJob("weights", name, memory, seconds, key, does, part=str(basis))
    memory = PROCESS + 3 * designs * stored + _PER_ROW * designs
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
