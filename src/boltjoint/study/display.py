"""Displays: the figures and tables of a study, each declared beside the function that makes it.

A declaration says what a figure or table is of, when a study has it, which files it reads, and
where it stands in the report with which words. The list of files, the inputs of rules, and the
captions and places on pages follow from it. ``report.displays`` has them all.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from boltjoint.study.artefact_list import Artefact

if TYPE_CHECKING:
    from boltjoint.study.artefact_list import Contents
    from boltjoint.study.stage_inputs import Results

#: a text, in which the fields of the artefact stand in braces, or a function of the artefact
Words = str | Callable[[Artefact], str]
#: files that a figure or table of a study is made from
Inputs = Callable[["Contents", Artefact], Iterable[Artefact]]


@dataclass(frozen=True)
class Display:
    """A kind of figure or table.

    Parameters
    ----------
    kind, form
        Its name, with which its files begin, and whether it is a figure or a table.
    make
        Function of the artefact, the results that it reads and its options; it returns a matplotlib
        ``Figure`` or a ``DataFrame``. Its module is read by every job of the workflow: it imports
        what draws and computes within the function.
    of
        What a study has it of: the fields of each, such as ``assembly`` or ``case`` and ``basis``.
    reads
        Functions that give the data and tables that it is made from.
    title
        First line of its caption; of a table also its heading and its name in the report.
    caption
        Further sentences of the caption.
    page, section, order
        Where it stands: one of ``names.PAGES``, None for the page of its case; the anchor of a
        section there, a new one if there is none; its place among others of that section.
    job
        Name of the job that makes it, with fields in braces; those of one name are made together.
    options
        Further arguments of the function: values of the configuration.
    is_compared
        Whether values of a source stand in it too, where a case is compared with one: the function
        is then told of the source as ``comparison``.
    stage
        Stage of its case by which memory and time are estimated (``estimate.Resources``); without
        one they are those of drawing and tabulating.
    """

    kind: str
    form: Literal["figure", "table"]
    make: Callable[..., Any]
    of: Callable[["Contents"], Iterable[Mapping[str, Any]]]
    reads: tuple["Inputs", ...]
    title: Words
    job: str
    caption: Words = ""
    page: str | None = None
    section: str = "further"
    order: int = 0
    options: Callable[["Contents", Artefact], Mapping[str, Any]] = lambda *_: {}
    is_compared: bool = False
    stage: str = ""

    def artefacts(self, contents: "Contents") -> Iterator[Artefact]:
        """All of this kind that a study has."""
        for fields in self.of(contents):
            yield Artefact(self.kind, self.form, **fields)

    def content(
        self,
        artefact: Artefact,
        results: "Results",
        options: Mapping[str, Any],
        comparison: object,
    ) -> Any:  # noqa: ANN401
        """The figure or table.

        Parameters
        ----------
        artefact
            What it is of.
        results
            The files that it is made from.
        options
            Further arguments of its function.
        comparison
            The source that the study is compared with (``report.comparison``).
        """
        source = {"comparison": comparison} if self.is_compared else {}
        return self.make(artefact, results, **options, **source)

    def title_of(self, artefact: Artefact) -> str:
        """First line of the caption."""
        return _in_words(self.title, artefact)

    def caption_of(self, artefact: Artefact) -> str:
        """Further sentences of the caption."""
        return _in_words(self.caption, artefact)

    def heading_of(self, artefact: Artefact) -> str:
        """Heading of a table that stands alone."""
        title = self.title_of(artefact)
        return f"{artefact.case}: {title}" if artefact.case else title[:1].upper() + title[1:]

    def page_of(self, artefact: Artefact) -> str:
        """The page that shows it."""
        return self.page or str(artefact.case)


def figure(kind: str, **declared: Any) -> Callable[[Callable[..., Any]], Display]:  # noqa: ANN401
    """Declare the figure that a function draws; the fields are those of ``Display``."""
    return lambda make: Display(kind, "figure", make, **declared)


def table(kind: str, **declared: Any) -> Callable[[Callable[..., Any]], Display]:  # noqa: ANN401
    """Declare the table that a function makes; the fields are those of ``Display``."""
    return lambda make: Display(kind, "table", make, **declared)


def data_of(*kinds: str, by: Sequence[str] = ()) -> Inputs:
    """The data of some kinds with the same values of some fields as the figure or table."""

    def inputs(contents: "Contents", artefact: Artefact) -> list[Artefact]:
        same = {name: getattr(artefact, name) for name in by}
        return contents.select(*kinds, form="data", **same)

    return inputs


def assembly_of_case(contents: "Contents", artefact: Artefact) -> list[Artefact]:
    """The mesh of the assembly of a case."""
    return contents.select("assembly", assembly=contents.study.case(str(artefact.case)).assembly)


def table_of_same(contents: "Contents", artefact: Artefact) -> list[Artefact]:
    """The table of the same kind and of the same."""
    return contents.select(artefact.kind, form="table", **artefact.fields)


@dataclass(frozen=True)
class Job:
    """A job that makes figures or tables of a study.

    Attributes
    ----------
    name
        Name of its rule.
    artefacts, options
        What it makes, and the further arguments of each.
    inputs
        The files that it reads.
    modules
        The modules that declare what it makes.
    is_compared
        Whether it reads values of a source.
    counterparts
        Cases of the source that the case of each is compared with, None where there is none.
    stage, subject
        By which memory and time are estimated.
    """

    name: str
    artefacts: tuple[Artefact, ...]
    options: tuple[Mapping[str, Any], ...]
    inputs: tuple[str, ...]
    modules: tuple[str, ...]
    is_compared: bool
    counterparts: tuple[str | None, ...]
    stage: str
    subject: str


class Displays:
    """The figures and tables that studies have, by kind and form.

    Parameters
    ----------
    displays
        In the order in which they are listed and, within a section, stand on a page.

    Raises
    ------
    ValueError
        If two figures or two tables have one name.
    """

    def __init__(self, displays: Iterable[Display]) -> None:
        self._by_name: dict[tuple[str, str], Display] = {}
        for display in displays:
            if self._by_name.setdefault((display.form, display.kind), display) is not display:
                raise ValueError(f"there are two {display.form}s called {display.kind!r}")

    def __iter__(self) -> Iterator[Display]:
        """All of them."""
        return iter(self._by_name.values())

    def of(self, artefact: Artefact) -> Display:
        """The declaration of a figure or table."""
        return self._by_name[artefact.form, artefact.kind]

    def on_page(self, contents: "Contents", page: str) -> list[Artefact]:
        """The figures and tables of a page."""
        return [
            artefact
            for form in ("figure", "table")
            for artefact in contents.select(form=form)
            if self.of(artefact).page_of(artefact) == page
        ]

    def jobs(self, contents: "Contents", form: str) -> list[Job]:
        """The jobs that make all figures or all tables of a study."""
        by_name: dict[str, list[Artefact]] = {}
        for artefact in contents.select(form=form):
            name = self.of(artefact).job.format(**artefact.fields)
            by_name.setdefault(name, []).append(artefact)
        return [self._job(name, artefacts, contents) for name, artefacts in by_name.items()]

    def _job(self, name: str, artefacts: list[Artefact], contents: "Contents") -> Job:
        displays = [self.of(artefact) for artefact in artefacts]
        pairs = list(zip(displays, artefacts, strict=True))
        read = (
            data.path
            for display, one in pairs
            for inputs in display.reads
            for data in inputs(contents, one)
        )
        return Job(
            name=name,
            artefacts=tuple(artefacts),
            options=tuple(dict(display.options(contents, one)) for display, one in pairs),
            inputs=tuple(dict.fromkeys(read)),
            modules=tuple(sorted({display.make.__module__ for display in displays})),
            is_compared=any(
                display.is_compared and contents.is_compared(one.case) for display, one in pairs
            ),
            counterparts=tuple(
                contents.study.case(one.case).published if one.case else None for one in artefacts
            ),
            stage=next((display.stage for display in displays if display.stage), ""),
            subject=artefacts[0].case or artefacts[0].assembly or "",
        )


def _in_words(words: Words, artefact: Artefact) -> str:
    return words(artefact) if callable(words) else words.format(**artefact.fields)
