"""Natural frequencies of a case without contact, slipping and sticking, in each of its bases."""

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.names import REFERENCE
from boltjoint.report.pages.content import PageContent
from boltjoint.report.pages.markup import prose, table_with_caption
from boltjoint.study.trusted_bases import by_trust

#: resonances in the table
_MOST = 6


def natural_frequencies(name: str, case: Case, content: PageContent) -> Markup:
    """Table of the lowest natural frequencies by basis and state of the contact.

    Parameters
    ----------
    name, case
        The case.
    content
        Of a page that has its node-to-node joints.
    """
    # it takes long to import
    from boltjoint.joint.io import joint_from_dataset
    from boltjoint.report.pages.interactive.natural_modes import natural_modes

    rows = []
    for basis in by_trust(case.bases):
        fields = {"case": name, "basis": basis, "joint": REFERENCE[0]}
        if not content.results.has("joint", **fields):
            continue
        stored = content.results.dataset("joint", **fields)
        if "natural_frequency" not in stored:
            continue
        modes = natural_modes(joint_from_dataset(stored), _MOST)
        rows += [
            {
                "basis": basis,
                "resonance": number + 1,
                **{
                    f"{state.replace(' ', '_')}_Hz": frequencies.frequency[number]
                    for state, frequencies in modes.items()
                },
            }
            for number in range(len(modes["sticking"].frequency))
        ]
    if not rows:
        return Markup()
    notes = [prose("case").natural_frequencies("slipping_Hz" in rows[0])]
    return table_with_caption(
        pd.DataFrame(rows), f"Natural frequencies of {name}", notes, groups=["basis"]
    )
