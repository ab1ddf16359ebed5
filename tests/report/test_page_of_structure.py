import numpy as np
import pandas as pd
from page_examples import DRAWING, ROOT, SOURCE, figure, repeated_ids

from boltjoint.config.study import load_study
from boltjoint.report.pages.structure import structure_page
from boltjoint.study.published import Published


def structure_of(names, files=()):
    assemblies = load_study(ROOT).assemblies
    other = assemblies["three_bolt"].material.model_copy(update={"youngs_modulus_GPa": 210.0})
    mine = assemblies["three_bolt"].model_copy(update={"material": other})
    assemblies = {name: assemblies.get(name, mine) for name in names}
    return structure_page(assemblies, list(files), Published(SOURCE), ["mine"])


def test_material_of_the_source_stands_beside_its_assemblies():
    of_source = figure(structure_of(["three_bolt", "mine"]), "dimensions-table")
    assert "The source has three_bolt. Its dimensions are not known" in of_source
    assert "Young's modulus (GPa) 190 210 190" in of_source.replace("&#39;", "'")
    assert "Table 3.1 of the source" in of_source
    own = figure(structure_of(["mine"]), "dimensions-table")
    assert "source" not in own
    assert "calibrated" not in own


def test_figures_of_any_assembly_are_captioned(tmp_path):
    stems = {
        "mesh_free-4": "Mesh of free-4",
        "modes_a_linear_free-4": "Bending modes of a_linear",
        "contact_a_node-to-node_preload=1e+20": "a_node-to-node with 1e+20 N per bolt",
        "deformation_free-4_preload=10": "Shape of free-4 with 10 N per bolt",
    }
    (tmp_path / "figures").mkdir()
    (tmp_path / "tables").mkdir()
    for stem in stems:
        (tmp_path / f"figures/{stem}.svg").write_text(DRAWING)
    contact = {"assembly": ["a_linear"], "published_pairs": [np.nan], "pairs": [10]}
    pd.DataFrame(contact).to_csv(tmp_path / "tables/contact.csv", index=False)
    page = structure_of(["mine"], map(str, sorted(tmp_path.rglob("*.*"))))
    for stem, title in stems.items():
        assert figure(page, stem).strip().startswith(title)
    assert not repeated_ids(page)
    assert "published numbers" not in page
