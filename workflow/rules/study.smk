# The study that the configuration describes, and what the rules ask of it.
#
# The library reads its files: Snakemake's own reader (configfile:, --configfile) is a template engine,
# which runs the code in a file that asks for it.

import os
from pathlib import Path

from snakemake.logging import logger

from boltjoint.config.options import COMPARED_RESONANCES
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.names import PAGES, REFERENCE, is_enriched
from boltjoint.report.pages import shown as pages
from boltjoint.study import estimate, layout
from boltjoint.study.layout import targets
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


wildcard_constraints:
    assembly="|".join(study.assemblies),
    case="|".join(study.cases),
    modes=r"[a-z]+-\d+",
    newton=r"[0-9.e+-]+",
    regions=r"(regions|clusters)=(\d+|auto)",
    fit=r"(elements|harmonic)=\d+",
    joint=r"node-to-node|(regions|clusters)=(\d+|auto)(/(elements|harmonic)=\d+|/table)?",
    flat=r"node-to-node|(regions|clusters)=(\d+|auto)(_(elements|harmonic)=\d+|_table)?",
    coordinates=r"linear|backbone|(complex-)?rdnm-\d+",
    resonance=r"\d+",


def library(script):
    """Hash of a script and the modules it uses: another content makes what it wrote stale."""
    return source_hash(Path(workflow.basedir, "workflow/scripts", script))


# the tables of the source study
published = sorted(os.path.relpath(path) for path in SOURCE.glob("*.csv"))


def case_of(wildcards):
    return study.case(wildcards.case)


def source_of(wildcards):
    """The source's tables and figures that a case is compared with."""
    return Published(SOURCE, case_of(wildcards).published)


def solved(wildcards):
    """Joint, coordinates and resonance of all responses of a case in a basis."""
    return [
        (joint, coordinates, resonance)
        for modes, joint, coordinates, resonance in layout.solved(study, wildcards.case)
        if modes == wildcards.modes
    ]


def solved_in_linear_modes(wildcards):
    """The joints of a case and basis that are solved in linear modes around resonance 1."""
    return [joint for joint, *how in solved(wildcards) if how == [REFERENCE[1], 1]]


def backbones(wildcards):
    """The joints of a case and basis whose backbones are drawn together."""
    return layout.backbones(
        study, wildcards.case, wildcards.modes, int(wildcards.resonance)
    )


def checked(wildcards):
    """Those of them that a march in time can check."""
    return [which for which in solved(wildcards) if layout.is_checked(study, which[1])]


def reference_of(wildcards):
    """The node-to-node response in linear modes, where it is solved and is not the figure's own."""
    resonance = int(wildcards.resonance)
    reference = (wildcards.modes, *REFERENCE, resonance)
    joint = layout.unflat(wildcards.flat)
    own = (wildcards.modes, joint, wildcards.coordinates, resonance)
    if own == reference or reference not in layout.solved(study, wildcards.case):
        return []
    return layout.response(wildcards.case, *reference)


def shown_on(page):
    """Figures and tables of a page of the report."""
    return pages.shown_on(page, targets(study), study.cases)


def tables_of_cases(*kinds):
    """Tables of these kinds on the pages of all cases."""
    names = tuple(f"results/tables/{kind}_" for kind in kinds)
    return [
        path
        for case in study.cases
        for path in shown_on(case)
        if path.startswith(names)
    ]


def nodes_of(case):
    """The node-to-node joints of a case, one in each basis."""
    return [
        layout.joint(case, family, REFERENCE[0]) for family in study.case(case).bases
    ]
