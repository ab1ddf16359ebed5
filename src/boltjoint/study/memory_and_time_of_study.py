"""Memory and time of a study: its largest job, and all (``memory_and_time_of_jobs``)."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

from boltjoint.config.study import Study
from boltjoint.config.types import (
    ASSEMBLY_FOLDER,
    CASE_FOLDER,
    CONFIG_FILE,
    refusing_exceptions,
)
from boltjoint.provenance.environment import machine_memory as machine_memory
from boltjoint.structure.bolt_tension import tension_of, yield_warning
from boltjoint.study.artefact_list import Contents
from boltjoint.study.memory_and_time_of_jobs import all_jobs, jobs_on
from boltjoint.study.progress import duration

_GIB = 2**30
#: the two Snakemakes that start a job on a node of a cluster [byte]
_SNAKEMAKE = 290e6


@dataclass(frozen=True)
class Estimate:
    """What a study needs.

    Attributes
    ----------
    memory
        Memory of the job that needs most [byte].
    key
        File and key by which that job is made smaller.
    job
        What that job does.
    seconds
        Time on one core [s], for the finite elements, the fits, the responses with their converged
        peaks, the peaks that are compared and the time integration.
    responses
        Frequency responses.
    designs
        Designs of sweeps.
    meshes, tightenings, joints
        Meshes, tightenings and joints of sweeps: assemblies that are meshed, rows of bolts that are
        tightened, and joints that are made.
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


def estimate(study: Study) -> Estimate:
    """What a study needs: memory of its largest job, and time of all jobs.

    Raises
    ------
    ConfigError
        If the values of a file cannot be estimated.
    """
    with refusing_exceptions(CONFIG_FILE, "planned"):
        contents = Contents(study)
        contents.select("preload")
    jobs, variants = list(all_jobs(contents)), study.possible_variants()
    largest = max(jobs, key=lambda job: job.memory)
    return Estimate(
        memory=largest.memory,
        key=largest.key,
        job=largest.does,
        seconds=sum(job.seconds for job in jobs),
        responses=sum(len(case.responses) * len(case.levels) for case in study.cases.values()),
        designs=sum(study.designs.values()),
        meshes=len({variant.assembly_name for variant in variants}),
        tightenings=len({(variant.assembly_name, variant.case.preload) for variant in variants}),
        joints=len({files[-1] for name in study.swept for files in contents.joints_of_sweep(name)}),
    )


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
    time = duration(needed.seconds / (cores or 1))
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
        f"Estimate: {solved} in {time} {where}, "
        f"starting from scratch; up to {needed.memory / _GIB:.2g} GiB of memory a job "
        f"({needed.job})"
    )
    return line if memory is None else f"{line}, of {memory / _GIB:.3g} GiB"


def overstrained(study: Study) -> list[str]:
    """A line for each preload that strains the shanks of an assembly beyond yield."""
    tightened = [
        (f"{CASE_FOLDER}/{name}.yaml", study.assemblies[case.assembly], case.preload)
        for name, case in study.cases.items()
    ]
    used = {case.assembly for case in study.cases.values()}
    tightened += [
        (f"{ASSEMBLY_FOLDER}/{name}.yaml", described, preload)
        for name, described in study.assemblies.items()
        if name not in used and (preload := described.own_preload) is not None
    ]
    lines = []
    for file, described, preload in tightened:
        if described.shank is None:
            continue
        largest = float(tension_of(preload.of_bolts, described.bolt_count).max())
        if sentence := yield_warning(largest, *described.shank):
            lines.append(f"{file}: preload_N: {sentence}")
    return lines


#: minutes of a job whatever it computes, and by how much more time it may take than estimated
_LEAST_RUNTIME, _ROOM = 10, 3


def seconds_of_runtime(runtime: float) -> float:
    """The estimated time [s] of a job whose ``runtime`` [min] is that of ``Resources``."""
    return max(0.0, 60 * (runtime - _LEAST_RUNTIME) / _ROOM)


class Resources:
    """What the jobs of each stage need, as Snakemake is told: ``mem_mb`` and ``runtime`` [min].

    A cluster ends a job that takes more, so there is room: half as much memory again as estimated,
    with that of the processes of Snakemake, and a machine of a third the speed.
    """

    #: of jobs that only read, tabulate or draw: measured for figures
    SMALL = MappingProxyType(
        {"mem_mb": math.ceil((510e6 + _SNAKEMAKE) / 1e6), "runtime": _LEAST_RUNTIME}
    )

    def __init__(self, study: Study) -> None:
        self._contents = Contents(study)
        # a job asks for few of them
        self._jobs = cache(lambda subject: list(jobs_on(self._contents, subject)))

    def of(self, stage: str, subject: str, part: str = "", share: float = 1.0) -> Mapping[str, int]:
        """Those of a stage of an assembly, case or sweep, or of a part and in a share of its time.

        A part is the basis of responses, or basis and joint of a fit.
        """
        jobs = [
            job
            for job in (self._jobs(subject) if stage else ())
            if job.stage == stage and part in ("", job.part)
        ]
        if not jobs:
            return self.SMALL
        seconds = share * sum(job.seconds / job.parts for job in jobs)
        return {
            "mem_mb": math.ceil((1.5 * max(job.memory for job in jobs) + _SNAKEMAKE) / 1e6),
            "runtime": math.ceil(_LEAST_RUNTIME + _ROOM * seconds / 60),
        }

    def of_any(self, stage: str) -> Mapping[str, int]:
        """The largest of a stage of any sweep."""
        resources = [self.of(stage, sweep) for sweep in self._contents.study.sweeps] or [self.SMALL]
        return {key: max(resource[key] for resource in resources) for key in self.SMALL}
