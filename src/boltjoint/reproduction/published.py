"""The published tables and figures of the thesis, by case study and joint.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from boltjoint import checks
from boltjoint.names import Basis
from boltjoint.reproduction.case_studies import CASE_STUDIES, name_case_studies

#: the modal basis of all case studies of the source
BASIS = Basis("free-4")


@dataclass(frozen=True)
class Published:
    """The published tables in a folder, of one case study or of none.

    Parameters
    ----------
    folder
        The folder of the tables and their index ``tables.csv``; without one there are none.
    case
        Name of the case study in the source; without one there is nothing to compare with.

    Raises
    ------
    ValueError
        If the source has no such case study.
    """

    folder: Path | None = None
    case: str | None = None

    def __post_init__(self) -> None:
        """Refuse a case study that the source does not have."""
        if self.folder is not None:
            object.__setattr__(self, "folder", checks.path("folder", self.folder))
        if self.case is None:
            return
        checks.instance("case", self.case, str)
        if self.case not in self.case_studies:
            raise ValueError(
                f"the source has no case study {self.case!r}; "
                f"there are: {', '.join(self.case_studies)}"
            )

    @classmethod
    def among(cls, paths: Iterable[str], case: str | None = None) -> "Published":
        """The tables in the folder of which the index is among some files; none if it is not."""
        folders = (Path(path).parent for path in paths if Path(path).name == CASE_STUDIES)
        folder = next(folders, None)
        return cls(folder, case if folder else None)

    @property
    def is_empty(self) -> bool:
        """Whether there are no tables at all."""
        return self.folder is None

    @property
    def case_studies(self) -> list[str]:
        """Names of the source's case studies."""
        return name_case_studies(self.folder)

    @property
    def assemblies(self) -> list[str]:
        """Names of the source's assemblies."""
        return list(dict.fromkeys(self._read(CASE_STUDIES)["assembly"]))

    def material(self) -> dict[str, float]:
        """The material of the source's assemblies, by the keys of an assembly's configuration."""
        (printed,) = self._read("material.csv").to_dict("records")
        return {key: float(value) for key, value in printed.items() if key != "material"}

    def natural_frequencies(self) -> pd.DataFrame:
        """Columns ``assembly, bending_mode, frequency_Hz``, of all assemblies."""
        return self._read("natural_frequencies.csv").drop(columns="figure")

    def contact_nodes(self) -> pd.DataFrame:
        """Columns ``assembly, contact_law, contact_nodes``, of all case studies."""
        cases = self._read(CASE_STUDIES)
        return cases[["assembly", "contact_law", "contact_nodes"]].drop_duplicates()

    def time_reductions(self) -> pd.DataFrame:
        """Published solution times of the case study, by joint, coordinates and force.

        Returns
        -------
        DataFrame
            Columns ``source_table, joint, coordinates, force_N, published_s,
            published_reduction_percent``; the reduction is against the node-to-node joint in linear
            modes. Times were printed for node-to-node joints only.
        """
        parts = []
        for kind in ("times", "reductions"):
            for table in self._tables(kind).itertuples():
                printed = self._read(f"{table.file}.csv")
                for coordinates, column in _SOLVED_IN.items():
                    if kind == "times":
                        seconds = printed[f"time_{column}_s"]
                        reduction = 100 * (1 - seconds / printed["time_msm_s"])
                    else:
                        seconds = float("nan")
                        reduction = printed[f"reduction_{column}_percent"]
                    rows = {
                        "source_table": table.table,
                        "joint": table.joint,
                        "coordinates": coordinates,
                        "force_N": printed["force_N"].astype(float),
                        "published_s": seconds,
                        "published_reduction_percent": reduction,
                    }
                    parts.append(pd.DataFrame(rows))
        return pd.concat([_NO_TIMES, *parts])

    def parameters(self, joint: str) -> pd.DataFrame:
        """Published elements of a reduced joint, in the order of the source.

        Returns
        -------
        DataFrame
            Columns ``joint, element, k_kN_per_mm, mu_n_N`` and ``source_table``; empty where the
            source prints none.
        """
        tables = self._tables("parameters")
        mine = tables[tables["joint"] == joint]
        frames = [
            self._read(f"{file}.csv").set_index(["joint", "element"]) for file in mine["file"]
        ]
        if not frames:
            return pd.DataFrame(columns=["joint", "element", "k_kN_per_mm", "mu_n_N"])
        elements = pd.concat(frames, axis=1).reset_index()
        elements = elements[elements["element"] <= _elements(joint)]
        return elements.assign(source_table=" and ".join(mine["table"]))

    def case_study(self) -> dict[str, str]:
        """What the source says of the case study, as in ``case_studies.csv``; empty for none."""
        cases = self._index(CASE_STUDIES)
        return next(iter(cases[cases["case"] == self.case].to_dict("records")), {})

    def tables(self) -> pd.DataFrame:
        """Index of the published tables, of all case studies: ``table, case, kind, joint``."""
        return self._index("tables.csv").drop(columns="file")

    def figures(self) -> pd.DataFrame:
        """Index of the published figures, of all case studies, as text.

        Returns
        -------
        DataFrame
            A row for each figure, with its number under ``figure`` and in a few words what it
            ``shows``; ``not_made`` is the reason why nothing here corresponds to it, if so. Where
            the source draws several ways to solve in one figure, ``coordinates`` has them all.
        """
        return self._index("figures.csv")

    def figures_of(self, kind: str, **values: object) -> pd.DataFrame:
        """The published figures that correspond to a figure of a study.

        Parameters
        ----------
        kind
            Kind of the figure, such as ``response`` or ``contact``.
        values
            Values of further columns of the index, such as ``joint`` or ``assembly``. A figure of
            a case study is sought in the case study at hand.
        """
        index = self.figures()
        same = (index["kind"] == kind) & ((index["case"] == "") | (index["case"] == self.case))
        for column, value in values.items():
            same &= index[column].str.split().map(lambda listed, one=str(value): one in listed)
        return index[same]

    def region_of_loops(self, joint: str) -> int:
        """The region whose hysteresis loops the source shows; the first where it shows none."""
        regions = self.figures_of("loops", joint=joint)["region"]
        return int(regions.iloc[0]) if len(regions) else 1

    def implied_preload(self) -> float | None:
        """Preload per bolt [N] at which the fitted elements of the case study slip as printed.

        The slip forces of all elements together are the friction coefficient times the load of all
        bolts. None where the source prints no elements.
        """
        facts = self.case_study()
        for joint in self._tables("parameters")["joint"]:
            total = self.parameters(joint)["mu_n_N"].sum()
            return float(total / (float(facts["mu"]) * int(facts["bolts"])))
        return None

    def _tables(self, kind: str) -> pd.DataFrame:
        tables = self._index("tables.csv")
        return tables[(tables["case"] == self.case) & (tables["kind"] == kind)]

    def _index(self, file: str) -> pd.DataFrame:
        # as text: 3.1 and 3.10 are two tables
        return self._read(file, dtype=str, keep_default_na=False)

    def _read(self, file: str, **options: object) -> pd.DataFrame:
        if self.folder is None:
            return pd.DataFrame(columns=_COLUMNS[file], dtype=str)
        return pd.read_csv(self.folder / file, **options)


#: columns of the files that are asked of where there is no source
_COLUMNS = {
    CASE_STUDIES: ["case", "assembly", "contact_law", "contact_nodes"],
    "natural_frequencies.csv": ["assembly", "bending_mode", "frequency_Hz", "figure"],
    "tables.csv": ["table", "case", "kind", "joint", "file"],
    "figures.csv": [
        *("figure", "case", "assembly", "kind", "joint", "coordinates", "resonance", "region"),
        *("preload_N", "shows", "not_made"),
    ],
}

_NO_TIMES = pd.DataFrame(
    {
        **dict.fromkeys(("source_table", "joint", "coordinates"), pd.Series(dtype=str)),
        **dict.fromkeys(
            ("force_N", "published_s", "published_reduction_percent"), pd.Series(dtype=float)
        ),
    }
)

#: coordinates of the source by their names here
_SOLVED_IN = {"linear": "msm", "rdnm-1": "rdnm"}


def _elements(joint: str) -> int:
    # Table 3.11 prints its first column again as a seventh
    return int(joint.rsplit("=", 1)[1])
