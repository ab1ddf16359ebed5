"""The page of the assemblies: what all cases start from."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from boltjoint import dataset
from boltjoint.config.assembly import Assembly
from boltjoint.report.pages import markup
from boltjoint.report.pages.markup import Section, number, source, table
from boltjoint.report.pages.shown import Shelf, menu
from boltjoint.study.published import Published

_MATERIAL = {
    "youngs_modulus_GPa": "Young's modulus (GPa)",
    "poissons_ratio": "Poisson's ratio",
    "density_kg_per_m3": "density (kg/m³)",
}


def page(
    assemblies: Mapping[str, Assembly],
    files: Sequence[str],
    published: Published,
    cases: Sequence[str],
) -> str:
    """Dimensions, modes and contact of all assemblies.

    Parameters
    ----------
    assemblies
        By name, as configured.
    files
        Figures and tables (CSV) to show, and the mesh (``assembly.nc``) of every assembly.
    published
        The source's tables.
    cases
        Names of the study's cases, to which the page links.
    """
    shelf = Shelf(files, published)
    sections = [
        Section("dimensions", "Dimensions and meshes", _dimensions(assemblies, shelf)),
        Section("modes", "Bending modes without contact", _modes(shelf)),
        Section("contact", "Contact under bolt preload", _contact(shelf)),
        *shelf.rest(),
    ]
    lead = (
        "<p>Two bars, each cut to half its height over the lap, clamped at one end and held "
        "by a row of bolts. This page has what all cases start from: the finite-element meshes, "
        "the bending modes with the contact between the bars removed, and what tightening the "
        "bolts does to the contact.</p>"
    )
    return markup.page("Structure", "Assemblies", lead, sections, menu(cases), "structure.html")


def _dimensions(assemblies: Mapping[str, Assembly], shelf: Shelf) -> str:
    meshes = {Path(path).parent.name: dataset.load(path) for path in shelf.data("assembly.nc")}
    columns = {}
    for name, assembly in assemblies.items():
        bar, bolts, material = assembly.bar, assembly.bolts, assembly.material
        diameters = (bolts.shank_diameter_mm, bolts.hole_diameter_mm, bolts.head_diameter_mm)
        columns[name] = {
            "width of the bars (mm)": number(bar.width_mm),
            "height outside the lap (mm)": number(bar.height_mm),
            "clamp to lap (mm)": number(bar.free_length_mm[0]),
            "lap (mm)": number(bar.lap_mm),
            "lap to free end (mm)": number(bar.free_length_mm[1]),
            "bolts": str(len(bolts.positions_from_lap_start_mm)),
            "bolts, from the start of the lap (mm)": _listed(bolts.positions_from_lap_start_mm),
            "diameters of shank, hole and head (mm)": _listed(diameters),
            **{words: number(getattr(material, key)) for key, words in _MATERIAL.items()},
        }
        if name in meshes:
            sizes = meshes[name].sizes
            columns[name] |= {
                "nodes": str(sizes["node"]),
                "elements": str(sizes["element"]),
                "contact pairs": str(sizes["pair"]),
            }
    theirs = [name for name in assemblies if name in shelf.published.assemblies]
    notes = []
    if theirs:
        columns["in the source"] = {
            _MATERIAL[key]: number(value) for key, value in shelf.published.material().items()
        }
        notes = [
            f"The source has {' and '.join(theirs)}. Its dimensions are not known: those here were "
            "chosen to meet its natural frequencies and its numbers of contact nodes. Its material "
            "is printed.",
            source("Table", ["3.1"]),
        ]
    frame = pd.DataFrame(columns).rename_axis("quantity").reset_index()
    described = table(
        frame,
        "Dimensions, material and mesh",
        notes,
        anchor="dimensions-table",
        verbatim=True,
    )
    return described + shelf.draw(
        "mesh",
        "Mesh of {subject}",
        "From above at an angle, the contact surface from above, and a cut along the middle of the "
        "width. The bolts are tied to the bars under head and nut.",
    )


def _modes(shelf: Shelf) -> str:
    body = (
        "<p>With the contact removed, the two bars slide on each other where the lap bends, and "
        "that sliding is all that friction acts on. Responses are built from these modes, or, in "
        "an <i>enriched</i> basis, from combinations of them with shapes that hold the contact."
        "</p>\n"
    )
    while found := shelf.table("natural_frequencies"):
        shown, frame = found
        worst = frame["difference_percent"].abs().max()
        note = "" if pd.isna(worst) else f"They meet the published ones within {worst:.2f} %."
        body += table(
            frame,
            f"Natural frequencies of the basis {shown.modes}",
            [note],
            shown.anchor,
            shown.from_page,
            groups=["assembly"],
        )
    return body + shelf.draw(
        "modes",
        "Bending modes of {subject}",
        "Cut along the middle of the width; displacements are enlarged.",
    )


def _contact(shelf: Shelf) -> str:
    body = (
        "<p>Tightening the bolts presses the bars together around them and lifts the ends of the "
        "lap apart. The load of a pair sets the force at which its friction element slips; where a "
        "pair is open, its gap has to close before there is any.</p>\n"
    )
    if found := shelf.table("contact"):
        shown, frame = found
        printed = (
            "The published numbers are those of friction elements: one on every pair where the "
            "normal load varies, one on every loaded pair where it is constant."
        )
        body += table(
            frame,
            "Contact of every assembly and preload",
            [printed if frame["published_pairs"].notna().any() else ""],
            shown.anchor,
            shown.from_page,
            groups=["assembly"],
        )
    body += shelf.draw(
        "contact",
        "{subject} with {newton} N per bolt",
        "Every pair is drawn as the area that belongs to it. Load follows that area as much as "
        "pressure: pairs on the edge of a hole have about half the area of their neighbours, and "
        "with it half the slip force.",
    )
    return body + shelf.draw(
        "deformation",
        "Shape of {subject} with {newton} N per bolt",
        "Cut along the middle of the width; displacements are enlarged. The ends of every cut "
        "shank lie over one another by what tightening has shortened it.",
    )


def _listed(values: Sequence[float]) -> str:
    return ", ".join(map(number, values))
