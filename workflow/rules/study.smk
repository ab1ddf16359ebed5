# The study that the configuration describes, and what the rules ask of it.
#
# The library reads its files: Snakemake's own reader (configfile:, --configfile) is a template engine,
# which runs the code in a file that asks for it.

import os
from pathlib import Path

from snakemake.logging import logger

from boltjoint.config.convergence import COMPARED_RESONANCES
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.names import REFERENCE, Basis, JointName
from boltjoint.study import estimate, layout
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.published import Published
from boltjoint.workflow import environment
from boltjoint.workflow.code_dependencies import source_hash

SOURCE = Path(workflow.basedir, "resources/source")

if workflow.overwrite_configfiles:
    raise WorkflowError(
        "--configfile is not for this study: name the file by --config study=FILE, "
        "or by make reproduce STUDY=FILE"
    )

try:
    study = load_study(Path.cwd(), config, Published(SOURCE).case_studies)
except ConfigError as error:
    raise WorkflowError(f"The configuration cannot be used:\n{error}") from None

needed, memory = estimate.estimate(study), estimate.machine_memory()
# jobs, which read this file again, are asked no more
if workflow.is_main_process:
    if shortage := estimate.shortage(needed, memory):
        raise WorkflowError(shortage)
    for line in estimate.overstrained(study):
        logger.warning(line)

contents = Contents(study)
resources_of, SMALL = estimate.Resources(study).of, estimate.Resources.SMALL


wildcard_constraints:
    assembly="|".join(study.assemblies),
    case="|".join(study.cases),
    basis=Basis.wildcard(),
    preload_N=r"[0-9.e+-]+",
    joint=JointName.wildcard(),


def library(script):
    """Hash of a script and the modules it uses: another content makes what it wrote stale."""
    return source_hash(Path(workflow.basedir, "workflow/scripts", script))


# the tables of the source study
published = sorted(os.path.relpath(path) for path in SOURCE.glob("*.csv"))


def data(kind, **which):
    """Files of a kind of data."""
    return contents.files(kind, form="data", **which)


def node_to_node(case, basis):
    return layout.path("joint", case=case, basis=basis, joint=REFERENCE[0])


def preload_of(case):
    """The contact of the assembly of a case under the preload of that case."""
    found = study.case(case)
    return layout.path("preload", assembly=found.assembly, preload_N=found.preload_N)


def regions_of_joint(wildcards):
    """The joint of the same regions with all their elements."""
    regions = JointName(wildcards.joint).regions
    return layout.path(
        "joint", case=wildcards.case, basis=wildcards.basis, joint=regions
    )


def response(case, which):
    return layout.path("response", case=case, **which._asdict())


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


def reported(artefacts, subcategory):
    """CSV files of tables, as the report of the workflow lists them."""
    flagged = []
    for each in artefacts:
        how = {"labels": {"table": each.label}, "subcategory": subcategory}
        flagged.append(report(each.path, category="4. Tables", **how))
    return flagged


def html_of(artefacts):
    return [artefact.paths[1] for artefact in artefacts]


def table(kind, subcategory, **which):
    """CSV and HTML file of a table."""
    artefact = Artefact(kind, "table", **which)
    (csv,) = reported([artefact], subcategory)
    return {"csv": csv, "html": artefact.paths[1]}


def tables_of(*kinds, **which):
    return contents.select(*kinds, form="table", **which)


TABLES_OF_BASIS = ("accuracy", "states", "times", "fits", "regions", "elements")
references = {
    case: found[0] for case in study.cases if (found := contents.references(case))
}
drawn = contents.select(form="figure", page="accuracy") + contents.select(
    "sampling", form="figure"
)
drawn_tables = [
    artefact for figure in drawn for artefact in tables_of(figure.kind, **figure.which)
]


def published_of(case):
    """The source's tables and figures that a case is compared with."""
    return Published(SOURCE, study.case(case).published)


def figures_and_tables(**which):
    """Figures and tables, as those of a page of the report."""
    return contents.select(form="figure", **which) + tables_of(**which)


on_accuracy = figures_and_tables(page="accuracy") + tables_of("harmonic_peaks")
on_overview = figures_and_tables(page="overview") + tables_of(
    "accuracy", "times", "harmonic_peaks"
)
