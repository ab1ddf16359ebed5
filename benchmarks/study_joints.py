"""Joints of the study that are timed."""

from pathlib import Path

from boltjoint.joint.io import load_joint
from boltjoint.joint.model import Joint

RESULTS = Path(__file__).parents[1] / "results"


def joint_of(case: str, basis: str, joint: str) -> Joint:
    """A joint of the study; ``make benchmark`` makes those that are needed."""
    return load_joint(RESULTS / f"cases/{case}/{basis}/{joint}/joint.nc")
