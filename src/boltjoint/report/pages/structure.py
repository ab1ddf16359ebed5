"""The page of the assemblies: dimensions, modes without contact, contact under preload."""

from collections.abc import Mapping, Sequence

import pandas as pd
from markupsafe import Markup

from boltjoint.config.assembly import Assembly
from boltjoint.config.bolts import Bolts
from boltjoint.report.pages.content import PageContent
from boltjoint.report.pages.document import Section, render_page
from boltjoint.report.pages.markup import prose, source_reference, table_with_caption
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.published import Published
from boltjoint.study.results import Results
from boltjoint.study.tables.html import number

_TEXT = prose("structure")

_MATERIAL = {
    "youngs_modulus_GPa": "Young's modulus (GPa)",
    "poissons_ratio": "Poisson's ratio",
    "density_kg_per_m3": "density (kg/m³)",
}


def structure_page(
    assemblies: Mapping[str, Assembly],
    artefacts: Sequence[Artefact],
    results: Results,
    published: Published,
    cases: Sequence[str],
) -> str:
    """Dimensions, modes and contact of all assemblies.

    Parameters
    ----------
    assemblies
        By name, as configured.
    artefacts
        Figures and tables of the page.
    results
        The content of the tables, and the mesh (``assembly.nc``) of every assembly.
    published
        The source's tables.
    cases
        Names of the study's cases, to which the page links.
    """
    content = PageContent(artefacts, results, published)
    sections = [
        Section("dimensions", "Dimensions and meshes", _dimensions(assemblies, content)),
        Section("modes", "Bending modes without contact", _modes(content)),
        Section("contact", "Contact under bolt preload", _contact(content)),
        *content.remainder(),
    ]
    return render_page("Structure", "Assemblies", _TEXT.lead(), sections, cases, "structure.html")


def _dimensions(assemblies: Mapping[str, Assembly], content: PageContent) -> Markup:
    columns = {}
    for name, assembly in assemblies.items():
        bar, bolts = assembly.bar, assembly.bolts
        diameters = (bolts.shank_diameter_mm, bolts.hole_diameter_mm, bolts.head_diameter_mm)
        columns[name] = {
            "width of the bars (mm)": number(bar.width_mm),
            "height outside the lap (mm)": number(bar.height_mm),
            "clamp to lap (mm)": number(bar.free_length_mm[0]),
            "lap (mm)": number(bar.lap_mm),
            "lap to free end (mm)": number(bar.free_length_mm[1]),
            "bolts": str(len(assembly.bolt_positions_mm)),
            "bolts, from the start of the lap (mm)": _listed(assembly.bolt_positions_mm),
            "diameters of shank, hole and head (mm)": _listed(diameters),
            **_washers(bolts),
            **_materials(assembly),
        }
        if content.results.has("assembly", assembly=name):
            mesh = content.results.dataset("assembly", assembly=name)
            columns[name] |= {
                "nodes": str(mesh.sizes["node"]),
                "elements": str(mesh.sizes["element"]),
                "contact pairs": str(mesh.sizes["pair"]),
            }
            if "initial_gap" in mesh:
                largest = 1e6 * mesh["initial_gap"].max().item()
                columns[name]["largest initial gap (μm)"] = number(largest)
    in_source = [name for name in assemblies if name in content.published.assemblies]
    notes = []
    if in_source:
        columns["in the source"] = {
            _MATERIAL[key]: number(value) for key, value in content.published.material().items()
        }
        notes = [
            _TEXT.dimensions_of_source(" and ".join(in_source)),
            source_reference("Table", ["3.1"]),
        ]
    frame = pd.DataFrame(columns).rename_axis("quantity").reset_index()
    described = table_with_caption(
        frame, "Dimensions, material and mesh", notes, anchor="dimensions-table", verbatim=True
    )
    return described + content.section("dimensions")


def _washers(bolts: Bolts) -> dict[str, str]:
    """Dimensions of the washers, where there are any."""
    washer = bolts.washer
    if washer is None:
        return {}
    hole = washer.hole_diameter_mm if bolts.has_narrow_washers else bolts.hole_diameter_mm
    return {
        "washers under": " and ".join(washer.under),
        "thickness of a washer, diameters of its hole and edge (mm)": _listed(
            (washer.thickness_mm, hole, washer.diameter_mm)
        ),
    }


def _materials(assembly: Assembly) -> dict[str, str]:
    """Material of the bars, and of bolts and washers where it is another."""
    others = {"of the bolts": assembly.bolt_material}
    if assembly.bolts.washer is not None:
        others["of the washers"] = assembly.washer_material
    rows = {words: number(getattr(assembly.material, key)) for key, words in _MATERIAL.items()}
    for which, material in others.items():
        if material != assembly.material:
            for key, words in _MATERIAL.items():
                quantity, _, unit = words.partition(" (")
                label = f"{quantity} {which}" + (f" ({unit}" if unit else "")
                rows[label] = number(getattr(material, key))
    return rows


def _modes(content: PageContent) -> Markup:
    body = _TEXT.modes()
    while table := content.table("natural_frequencies"):
        differences = table.frame.get("difference_percent", pd.Series(dtype=float))
        largest = differences.abs().max()
        note = "" if pd.isna(largest) else f"Within {largest:.2f} % of the published frequencies."
        body += table.html(notes=[note], groups=["assembly"])
    return body + content.section("modes")


def _contact(content: PageContent) -> Markup:
    body = _TEXT.contact()
    if table := content.table("contact"):
        published = table.frame.get("published_pairs", pd.Series(dtype=float)).notna().any()
        note = _TEXT.published_pairs() if published else ""
        body += table.html(notes=[note], groups=["assembly"])
    return body + content.section("contact")


def _listed(values: Sequence[float]) -> str:
    return ", ".join(map(number, values))
