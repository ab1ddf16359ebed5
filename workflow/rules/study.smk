# The study that the configuration describes, and what the rules ask of it.
#
# The library reads its files: Snakemake's own reader (configfile:, --configfile) is a template engine,
# which runs the code in a file that asks for it.

import importlib
import os
import sys
from functools import cache
from pathlib import Path

from snakemake.logging import logger
from snakemake.sourcecache import LocalSourceFile

from boltjoint.config import makers
from boltjoint.config.conflicts_of_measured import (
    calibrated_content,
    fits_preloads,
    range_of_ratios,
)
from boltjoint.config.numerical_options import COMPARED_RESONANCES
from boltjoint.config.study import load_study
from boltjoint.config.types import ASSEMBLY_FOLDER, ConfigError
from boltjoint.names import REFERENCE, Basis, JointName, Preload
from boltjoint.provenance import environment
from boltjoint.provenance.code_dependencies import Sources
from boltjoint.report.displays import DISPLAYS
from boltjoint.reproduction.case_studies import (
    INDEX,
    name_case_studies,
    name_tables,
    name_timed_joints,
)
from boltjoint.study import layout, memory_and_time_of_study, implausible_values
from boltjoint.study.artefact_list import Contents
from boltjoint.study.progress import STUDY_AS_NAMED, Progress
from boltjoint.study.response_list import headline_basis

RULES = workflow.current_basedir


def answer():
    """The answer of the study, and the page to open."""
    from boltjoint.report.answer_values import answers

    return answers(study, os.environ.get(STUDY_AS_NAMED, ""))


progress = Progress(
    answer,
    memory_and_time_of_study.seconds_of_runtime,
    workflow.output_settings.dryrun,
    has_words=STUDY_AS_NAMED in os.environ,
)
# jobs on other machines, and a workflow with this one as its module, tell all themselves
if workflow.is_main_process and workflow.modifier.base_snakefile is None:
    progress.attach(logger)


def own_file(path):
    """A file by its path in the folder of the workflow; of one on a server, the copy that is kept.

    That is the folder of this file, not of the study, nor of a Snakefile with this one as a module.
    """
    file = RULES.join(f"../../{path}")
    if isinstance(RULES, LocalSourceFile):
        return os.path.normpath(file.get_path_or_uri(secret_free=True))
    return workflow.sourcecache.get_path(file)


SOURCE = "resources/source"

if workflow.overwrite_configfiles:
    raise WorkflowError(
        "--configfile is not for this study: name the file by --config study=FILE, "
        "or by make reproduce STUDY=FILE"
    )

if workflow.modifier.path_modifier.replace_prefix("results/") != "results/":
    raise WorkflowError(
        "prefix and replace_prefix are not for this module: results lie where its library reads "
        "them; use it from a folder of its own"
    )

try:
    index_of_tables = own_file(f"{SOURCE}/{INDEX}")
    source_tables = [
        own_file(f"{SOURCE}/{name}") for name in name_tables(index_of_tables)
    ]
    CASE_STUDIES = name_case_studies(
        Path(source_tables[0]).parent if source_tables else None
    )
    timed_joints = name_timed_joints(index_of_tables)
    # jobs, which read this file again, find that of it which they need
    study = load_study(
        Path.cwd(), config, CASE_STUDIES, before=not workflow.is_main_process
    )
    needed = (
        memory_and_time_of_study.estimate(study) if workflow.is_main_process else None
    )
except ConfigError as error:
    raise WorkflowError(f"The configuration cannot be used:\n{error}") from None

# a job has one core, on which more threads of BLAS would wait for each other
os.environ.setdefault("OMP_NUM_THREADS", "1")
# glibc keeps the memory of arrays of up to 32 MB: to be given it anew takes as long as what they
# are used for
os.environ.setdefault("MALLOC_MMAP_THRESHOLD_", str(2**25))
os.environ.setdefault("MALLOC_TRIM_THRESHOLD_", str(2**28))
# of this machine; what a cluster has, it knows itself
cores = workflow.resource_settings.cores
# jobs are asked no more
if workflow.is_main_process:
    memory = None if cores is None else memory_and_time_of_study.machine_memory()
    if shortage := memory_and_time_of_study.shortage(needed, memory):
        raise WorkflowError(shortage)
    for line in (
        *implausible_values.implausible(study),
        *memory_and_time_of_study.overstrained(study),
    ):
        logger.warning(line)
    logger.info(memory_and_time_of_study.summary(needed, memory, cores))

contents = Contents(study, DISPLAYS, timed_joints)
resources_needed = memory_and_time_of_study.Resources(study)
resources_of, SMALL = resources_needed.of, resources_needed.SMALL


# a variant in a sweep is called by its values
VALUES = "(?:,[a-zA-Z0-9_.=+-]+)*"


wildcard_constraints:
    assembly=f"(?:{'|'.join(study.assemblies)}){VALUES}",
    case=f"(?:{'|'.join(study.cases | study.base_cases)}){VALUES}",
    sweep="|".join(study.sweeps) or "-",
    chunk="[0-9]+",
    basis=Basis.wildcard(),
    preload_N=Preload.wildcard(),
    joint=JointName.wildcard(),


hash_of = cache(Sources().hash_of)


def library(script, modules=()):
    """Hashes of a script, of further modules, and of all that they use.

    Another content makes what the script wrote stale.
    """
    files = [own_file(f"workflow/scripts/{script}")]
    files += [file for name in modules for file in files_of_module(name)]
    return [hash_of(file) for file in files]


def files_of_module(name):
    """The file of a module; all of another package, whose imports are not followed."""
    file = Path(sys.modules[name].__file__)
    is_own = name.partition(".")[0] == "boltjoint"
    return (
        [file]
        if is_own or file.name != "__init__.py"
        else sorted(file.parent.rglob("*.py"))
    )


def maker_of(assembly):
    """Module of the maker of an assembly, whose code no script names."""
    return makers.maker(study.assembly(assembly).type).__name__


def calculix_of(assembly):
    """Modules of the maker of an assembly, and of what compares it with CalculiX."""
    own = maker_of(assembly)
    return [
        own,
        importlib.import_module(getattr(sys.modules[own], "CALCULIX", own)).__name__,
    ]


def preload_of_assembly(assembly):
    """The contact of an assembly under its first preload, or 10 kN where it has none."""
    unknown = layout.path("preload", assembly=assembly, preload_N=10000)
    return [*data("preload", assembly=assembly), unknown][0]


def content_of(wildcards):
    """The description of an assembly."""
    return study.assembly(wildcards.assembly).model_dump(exclude={"preload_N"})


def table_of(sweep):
    """The table of the designs of a sweep; None where they are found otherwise."""
    return getattr(study.sweeps[sweep].design, "file", None)


def measured_files(case, key="fitted"):
    """The tables of the measured curves of a case, ``fitted`` or ``predicted``."""
    curves = getattr(study.case(case).measured, f"{key}_curves")
    return list(dict.fromkeys(curve.file for _, curve in curves))


def tightened_of(case):
    """Structure, assembly and modes of a case of which preloads of bolts are fitted."""
    if not fits_preloads(study.case(case).measured):
        return []
    of_assembly, basis = study.case(case).assembly, contents.calibrated(case)["basis"]
    return [
        layout.path("structure", assembly=of_assembly),
        layout.path("assembly", assembly=of_assembly),
        layout.path("modes", assembly=of_assembly, basis=basis),
    ]


def told_of_case(case):
    """What the file of a case says, without the defaults of what it does not."""
    found = study.case(case)
    told = found.model_dump(mode="json", exclude_unset=True, exclude={"measured"})
    if fits_preloads(found.measured):
        bolts = study.assembly(found.assembly).bolt_count
        told = {"preload_ratios": bolts * (1.0,), **told}
    return told


def bolts_of(case):
    """Excitation with sensors, and range of preloads of such a case."""
    found = study.case(case)
    if not fits_preloads(found.measured):
        return None, None
    excited = found.excitation, (*found.sensors, *found.outputs)
    return excited, range_of_ratios(found)


def maker_of_fit(case):
    """The maker of the assembly of such a case; none of others."""
    found = study.case(case)
    return [maker_of(found.assembly)] if fits_preloads(found.measured) else []


def hash_of_table(file):
    """Hash of the content of a table or map that the study names, as of code; None of none."""
    return None if file is None else study.hashes[file]


# a page has the captions of figures and tables
CAPTIONS = sorted({display.make.__module__ for display in DISPLAYS})

# the tables of the source study, if any case is compared with it
published = (
    sorted(map(os.path.relpath, source_tables)) if contents.is_compared() else []
)


def data(kind, **which):
    """Files of a kind of data."""
    return [each.path for each in contents.select(kind, form="data", **which)]


def node_to_node(case, basis):
    return layout.path("joint", case=case, basis=basis, joint=REFERENCE[0])


def variants_of_sweep(sweep, checking=False):
    """Values of each variant of a sweep, and how many joints it has."""
    joints = contents.joints_of_sweep(sweep, checking=checking)
    return [
        {"values": each.values, "joints": len(files)}
        for each, files in zip(study.possible_variants(sweep), joints)
    ]


@cache
def variants_by_case(sweep):
    """The variants of a sweep with their numbers, by the name of their case."""
    by_case = {}
    for numbered in enumerate(study.possible_variants(sweep)):
        by_case.setdefault(numbered[1].case_name, []).append(numbered)
    return by_case


def drawn_on_page(case):
    """What the page of a case draws under the pointer: curves, and its joint in space."""
    found = study.case(case)
    of_assembly = {"assembly": found.assembly}
    return [
        *data("response", case=case),
        *data("backbone", case=case),
        *data("calibration", case=case),
        *data("prediction", case=case),
        *data("assembly", **of_assembly),
        *data("modes", basis=headline_basis(found), **of_assembly),
        preload_of(case),
    ]


def is_of_sweep(case, basis, joint):
    """Whether only designs of sweeps have a joint: an impossible one does not end the study."""
    return not contents.select("joint", case=case, basis=basis, joint=joint)


def preload_of(case):
    """The contact of the assembly of a case under the preload of that case."""
    found = study.case(case)
    return layout.path("preload", assembly=found.assembly, preload_N=found.preload)


def any_preload(assembly):
    """The contact of an assembly under one of its preloads: for a ratio of them all are alike.

    With an initial gap they are not; then a contact-adapted basis has one (``other_preloads``).
    """
    varied = [
        layout.path("preload", assembly=assembly, preload_N=each.case.preload)
        for each in study.variants_of(ASSEMBLY_FOLDER, assembly)
    ]
    return (data("preload", assembly=assembly) or varied)[0]


def regions_of_joint(wildcards):
    """The joint of the same regions with all their elements."""
    regions = JointName(wildcards.joint).regions
    return layout.path(
        "joint", case=wildcards.case, basis=wildcards.basis, joint=regions
    )


def problem(case, basis):
    """A case in a basis, as ``study.solution.CaseInBasis`` takes it."""
    found = study.case(case)
    return {
        "case": case,
        "basis": basis,
        "forces": found.levels,
        "damping": found.structural_damping,
        "windows": {
            resonance: found.window_around(resonance)
            for resonance in found.resonances(basis)
        },
        "sampling": study.solver.sampling,
        "steps": study.solver.steps,
    }


def reported(artefacts):
    """CSV files of tables, as the report of the workflow lists them."""
    flagged = []
    for each in artefacts:
        display = DISPLAYS.of(each)
        of_structure = each.assembly or display.page == "structure"
        how = {
            "labels": {"table": display.title_of(each)},
            "subcategory": each.case or ("Structure" if of_structure else "All cases"),
        }
        flagged.append(report(each.path, category="4. Tables", **how))
    return flagged


on_accuracy = DISPLAYS.on_page(contents, "accuracy") + contents.select(
    "harmonic_peaks", "accuracy", "times", form="table"
)
on_overview = (
    DISPLAYS.on_page(contents, "overview")
    + contents.select("accuracy", form="table")
    + contents.select("mesh", form="figure")
    + [
        response
        for case in study.cases
        for response in contents.first_response(case, form="figure")
    ]
)
