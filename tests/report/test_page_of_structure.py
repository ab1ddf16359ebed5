import numpy as np
import pandas as pd
from page_examples import ROOT, figure, repeated_ids, results_of, save, source_of

from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.study import load_study
from boltjoint.names import Basis, Preload
from boltjoint.report.pages.content import anchor_of
from boltjoint.report.pages.structure import structure_page
from boltjoint.study.artefact_list import Artefact


def structure_of(names, artefacts=()):
    assemblies = load_study(ROOT).assemblies
    other = assemblies["three_bolt"].material.model_copy(update={"youngs_modulus_GPa": 210.0})
    mine = assemblies["three_bolt"].model_copy(update={"material": other})
    assemblies = {name: assemblies.get(name, mine) for name in names}
    results = results_of(artefacts)
    return structure_page(assemblies, artefacts, results, source_of(), ["mine"])


def test_material_of_the_source_stands_beside_its_assemblies():
    of_source = figure(structure_of(["three_bolt", "mine"]), "dimensions-table")
    assert "The source has three_bolt. Its dimensions are not known" in of_source
    assert "Young's modulus (GPa) 190 210 190" in of_source.replace("&#39;", "'")
    assert "Table 3.1 of the source" in of_source
    own = figure(structure_of(["mine"]), "dimensions-table")
    assert "source" not in own
    assert "calibrated" not in own


def test_washers_and_other_materials_are_told():
    steel = {"youngs_modulus_GPa": 206, "poissons_ratio": 0.3, "density_kg_per_m3": 7850}
    own = load_study(ROOT).assemblies["three_bolt"].model_dump()
    plain = {"mine": LapJoint.model_validate(own)}
    own["bolts"] |= {"material": steel}
    own["bolts"]["washer"] = {"thickness_mm": 1.6, "diameter_mm": 16, "under": ["nut"]}
    told = []
    for assemblies in (plain, {"mine": LapJoint.model_validate(own)}):
        page = structure_page(assemblies, [], results_of([]), source_of(), ["mine"])
        told.append(figure(page, "dimensions-table").replace("&#39;", "'"))
    assert "washer" not in told[0] and "modulus of the bolts" not in told[0]
    assert "yield strength of the bodies, by default (MPa) 355" in told[0]
    assert "yield strength of the bolts, by default (MPa) 640" in told[0]
    assert "washers under nut" in told[1]
    assert "thickness of a washer, diameters of its hole and edge (mm) 1.6, 9, 16" in told[1]
    assert "Young's modulus (GPa) 190" in told[1]
    assert "Young's modulus of the bolts (GPa) 206" in told[1]
    assert "Poisson's ratio of the washers 0.3" in told[1]


def test_figures_of_any_assembly_are_captioned(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    modes = Artefact("modes", "figure", "a_linear", basis=Basis("free-4"))
    contact = Artefact("contact", "figure", "a_node-to-node", Preload.of(1e20))
    titles = {
        Artefact("mesh", "figure", "free-4"): "Mesh of free-4",
        modes: "Bending modes of a_linear",
        contact: "a_node-to-node with 1e+20 N per bolt",
        Artefact(
            "deformation", "figure", "free-4", Preload("10")
        ): "Shape of free-4 with 10 N per bolt",
    }
    frame = {"assembly": ["a_linear"], "published_pairs": [np.nan], "pairs": [10]}
    table = save(Artefact("contact", "table"), pd.DataFrame(frame))
    page = structure_of(["mine"], [*map(save, titles), table])
    for artefact, title in titles.items():
        assert figure(page, anchor_of(artefact)).strip().startswith(title)
    assert not repeated_ids(page)
    assert "published numbers" not in page
