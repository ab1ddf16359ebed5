"""The page of the assemblies: dimensions, modes without contact, contact under preload."""

from collections.abc import Iterator, Mapping, Sequence

import pandas as pd
from markupsafe import Markup

from boltjoint.config.described import Described
from boltjoint.config.makers import page_of
from boltjoint.number_format import number
from boltjoint.report.comparison import Comparison
from boltjoint.report.pages.content import PageContent
from boltjoint.report.pages.document import Section, prose, render_page, table_with_caption
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.stage_inputs import Results

_TEXT = prose("structure")

#: rows for the size of a mesh, by the dimensions of ``assembly.nc``
_SIZES = {"node": "nodes", "element": "elements", "pair": "contact pairs"}


def structure_page(
    assemblies: Mapping[str, Described],
    artefacts: Sequence[Artefact],
    results: Results,
    comparison: Comparison,
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
    comparison
        The source that the study is compared with.
    cases
        Names of the study's cases, to which the page links.
    """
    content = PageContent(artefacts, results, comparison)
    kinds = dict.fromkeys(page_of(assembly.type).MEANING for assembly in assemblies.values())
    sections = [
        Section("dimensions", "Dimensions and meshes", _dimensions(assemblies, content)),
        *_modes(content),
        Section("contact", "Contact under bolt preload", _contact(content)),
        *content.remainder(),
    ]
    lead = _TEXT.lead(" ".join(kinds))
    return render_page("Structure", "Assemblies", lead, sections, cases, "structure.html")


def _dimensions(assemblies: Mapping[str, Described], content: PageContent) -> Markup:
    columns: dict[str, Sequence[str] | Mapping[str, str]] = {}
    for name, assembly in assemblies.items():
        facts = page_of(assembly.type).facts_of(assembly)
        texts = {words: _as_text(fact) for words, fact in facts.items()}
        if content.results.has("assembly", assembly=name):
            mesh = content.results.dataset("assembly", assembly=name)
            if dofs := mesh.attrs.get("degrees_of_freedom"):
                texts["degrees of freedom"] = str(dofs)
            sizes = ((words, mesh.sizes.get(size)) for size, words in _SIZES.items())
            texts |= {words: str(size) for words, size in sizes if size is not None}
            if "initial_gap" in mesh:
                largest = 1e6 * mesh["initial_gap"].max().item()
                texts["largest initial gap (μm)"] = number(largest)
        columns[name] = texts
    beside = content.comparison.dimensions(assemblies)
    columns |= beside.columns
    notes = list(beside.notes)
    if without := [
        name
        for name, assembly in assemblies.items()
        if not (assembly.HAS_MESH or assembly.HAS_SOLIDS)
    ]:
        notes.append(_TEXT.without_mesh(" and ".join(without)))
    frame = pd.DataFrame(columns).fillna("–").rename_axis("quantity").reset_index()
    described = table_with_caption(
        frame, "Dimensions, material and mesh", notes, anchor="dimensions-table", verbatim=True
    )
    return described + content.section("dimensions")


def _modes(content: PageContent) -> Iterator[Section]:
    """The section on modes without contact, of a study that has such bases."""
    body = Markup()
    while table := content.table("natural_frequencies"):
        note = content.comparison.note("natural_frequencies", table.frame)
        body += table.html(notes=[note], groups=["assembly"])
    body += content.section("modes")
    if body:
        yield Section("modes", "Modes without contact", _TEXT.modes() + body)


def _contact(content: PageContent) -> Markup:
    body = _TEXT.contact()
    if table := content.table("contact"):
        note = content.comparison.note("contact", table.frame)
        body += table.html(notes=[note], groups=["assembly"])
    return body + content.section("contact")


def _as_text(fact: float | str | Sequence[float]) -> str:
    """A number, numbers or words of a maker."""
    if isinstance(fact, str):
        return fact
    return number(fact) if isinstance(fact, int | float) else ", ".join(map(number, fact))
