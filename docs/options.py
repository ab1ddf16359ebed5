"""Write the page of numerical options from the docstrings of the library: ``make reference``."""

import importlib
import pkgutil
from dataclasses import fields
from pathlib import Path

import pandas as pd

import boltjoint
from boltjoint.options import Options

HERE = Path(__file__).parent
PAGE = HERE / "options.md"

_HEAD = """# Numerical options

Numbers of the library that can move a result, with what each does and where it comes from. Those
that users choose are keys of the [configuration](../config/README.md) too. Results store the
options that they were computed with in their attribute `options`.

The last columns are measured (`python benchmarks/option_sensitivity.py`): the largest relative
change of the frequency and of the amplitude of a peak when the option is halved and, where that is
allowed, doubled, all others at their defaults. First of solvers whose peaks solve the equations
themselves (linear, self-consistent and complex modes, backbone), then of those that keep the error
of a held basis (lagged modes). A dash stands where no peak moves by more than 1e-12.

Made from the library by `make reference`.
"""


def classes() -> list[type[Options]]:
    """All classes of options of the library, in the order of their modules."""
    for module in pkgutil.walk_packages(boltjoint.__path__, "boltjoint."):
        importlib.import_module(module.name)
    found = (each for each in Options.__subclasses__() if each.__module__.startswith("boltjoint."))
    return sorted(found, key=lambda each: (each.__module__, each.__name__))


def page() -> str:
    """Every class of options with a table."""
    measured = pd.read_csv(HERE / "option_sensitivity.csv").set_index(
        ["options", "option", "solvers"]
    )
    parts = [_HEAD]
    for options in classes():
        summary, _, rest = (options.__doc__ or "").partition("\n\n")
        remark = " ".join(rest.split("Parameters\n")[0].split())
        parts.append(f"\n## {options.__name__}\n\n`{options.__module__}`: {summary}\n")
        parts.append(f"\n{remark}\n" if remark else "")
        parts.append("\n| option | default | meaning | equations | held basis |\n")
        parts.append("|---|---|---|---|---|\n")
        defaults = {field.name: field.default for field in fields(options)}
        for names, text in options.descriptions():
            columns = zip(
                *(
                    (
                        f"`{name}`",
                        _shown(defaults[name]),
                        _moved(measured, options.__name__, name, "equations"),
                        _moved(measured, options.__name__, name, "held basis"),
                    )
                    for name in names
                ),
                strict=True,
            )
            option, default, *moved = ("<br>".join(each) for each in columns)
            parts.append(f"| {option} | {default} | {text} | {' | '.join(moved)} |\n")
    return "".join(parts).replace("``", "`")


def _shown(default: object) -> str:
    if isinstance(default, tuple):
        return ", ".join(map(_shown, default))
    return "as listed" if isinstance(default, Options) else f"{default:.6g}"


def _moved(measured: pd.DataFrame, *which: str) -> str:
    """Change of frequency and amplitude, or a dash; empty where it was not measured."""
    if which not in measured.index:
        return ""
    changes = measured.loc[which, ["frequency_change", "amplitude_change"]]
    return ", ".join(f"{each:.0e}" for each in changes) if changes.max() > 1e-12 else "–"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
