"""The parts of a page that answer the pointer, and the scripts that draw them."""

from dataclasses import dataclass

from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.report.pages.interactive.packing import compressed_json, compressed_plotly
from boltjoint.report.pages.markup import TEMPLATES
from boltjoint.study.results import Results


@dataclass(frozen=True)
class InteractiveParts:
    """Drawings of a case that answer the pointer, each empty where there is nothing to draw.

    Parameters
    ----------
    responses
        Responses and backbones.
    view
        The joint in space.
    scripts
        Data and library, at the end of the page.
    """

    responses: Markup
    view: Markup
    scripts: Markup

    @classmethod
    def of_case(cls, name: str, case: Case, results: Results) -> "InteractiveParts":
        """Those of a case, of as many of its files as are among the results."""
        # what computes takes long to import, and only pages of cases need it
        from boltjoint.report.pages.interactive.curves import curves_of_case
        from boltjoint.report.pages.interactive.view import view_of_case

        curves, view = curves_of_case(name, case, results), view_of_case(name, case, results)
        if curves is None and view is None:
            return cls(Markup(), Markup(), Markup())
        template = TEMPLATES.get_template("interactive/templates/interactive.html.j2").module
        packed = (
            None if content is None else compressed_json(content) for content in (curves, view)
        )
        return cls(
            template.responses("m/s²" if case.is_base_excited else "N") if curves else Markup(),
            template.view() if view else Markup(),
            template.scripts(*packed, compressed_plotly()),
        )
