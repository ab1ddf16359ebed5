"""What does not go together in the measured curves of a case, and what is fitted to them."""

import re
from collections.abc import Iterator
from typing import Any

from boltjoint.config.case import Case
from boltjoint.config.csv_table import TableError
from boltjoint.config.described import Described
from boltjoint.config.error_messages import choice
from boltjoint.config.files import StudyFiles
from boltjoint.config.measured import (
    AMPLITUDE_SCALE,
    Measured,
    MeasuredCurve,
    MeasuredSteppedSine,
    MeasuredTable,
)
from boltjoint.config.measured_tables import (
    LEVELS,
    BackboneTable,
    ResponseTable,
    read_backbone_table,
    read_response_table,
)
from boltjoint.config.numerical_options import Settings
from boltjoint.config.sweep import LEVEL_KEYS
from boltjoint.config.types import CONFIG_FILE, Problems
from boltjoint.config.varied_case import refused, with_all_ratios, with_values
from boltjoint.config.varied_keys import RATIOS, path_of, rescaled_keys, with_value_at
from boltjoint.names import REFERENCE, Basis, JointName
from boltjoint.regular_file import UnsuitableFile

#: of all natural frequencies without contact
FREQUENCY_RATIO = "frequency_ratio"
#: what is fitted of each region
OF_REGION = ("tangential_stiffness", "friction_coefficient")


def measurement_of(case: Case) -> Measured:
    """What was measured of a case, and what is fitted to it.

    Raises
    ------
    ValueError
        If nothing was.
    """
    if case.measured is None:
        raise ValueError("the case has nothing measured")
    return case.measured


def basis_of_measured(case: Case) -> Basis:
    """The basis in which parameters are fitted."""
    return measurement_of(case).basis or case.modes[0]


def calibrated_joint(name: str, case: Case) -> dict[str, Any]:
    """Case, basis and joint whose parameters are fitted to a measurement, for names of files."""
    return {"case": name, "basis": basis_of_measured(case), "joint": measurement_of(case).joint}


def calibrated_keys(case: Case) -> list[str]:
    """The keys of a case that may be fitted: they need no other joint."""
    return [key for key in rescaled_keys(case) if key not in LEVEL_KEYS]


def region_of(key: str) -> tuple[int, str] | None:
    """Number of the region and quantity of a parameter; None of other parameters.

    >>> region_of("joint.regions[2].friction_coefficient")
    (2, 'friction_coefficient')
    """
    named = re.fullmatch(rf"joint\.regions\[([0-9]{{1,6}})\]\.({'|'.join(OF_REGION)})", key)
    return named and (int(named[1]), named[2])


def ratio_keys(measured: Measured, assembly: Described | None) -> list[str]:
    """Preloads of bolts that may be fitted: the contact of all pairs is solved for them."""
    if assembly is None or measured.joint != REFERENCE[0]:
        return []
    return [f"{RATIOS}{bolt}]" for bolt in range(assembly.bolt_count)]


def fits_preloads(measured: Measured) -> bool:
    """Whether preloads of bolts are fitted, or differ from one curve to another."""
    of_curves = [key for _, curve in measured.all_curves for key in curve.configuration or ()]
    return any(key.startswith(RATIOS) for key in (*measured.parameters, *of_curves))


def range_of_ratios(case: Case) -> tuple[float, float]:
    """Lowest and highest preload of a bolt over that of the case, fitted or of a configuration."""
    measured, ends = measurement_of(case), list(case.preload_ratios or (1.0,))
    for key, parameter in measured.parameters.items():
        ends += [parameter.low, parameter.high] if key.startswith(RATIOS) else []
    for _, curve in measured.all_curves:
        of_curve = (curve.configuration or {}).items()
        ends += [value for key, value in of_curve if key.startswith(RATIOS)]
    return min(ends), max(ends)


def _ratios(measured: Measured) -> list[str]:
    """Other parameters than keys of the case, but for those of regions."""
    scales = [f"{AMPLITUDE_SCALE}[{curve.label}]" for _, curve in measured.fitted_curves]
    return [FREQUENCY_RATIO, AMPLITUDE_SCALE, *scales]


def _is_of_region(key: str, joint: JointName) -> bool:
    """Whether a parameter is of a region that the joint has."""
    region, count = region_of(key), joint.count
    if region is None or joint.division is None:
        return False
    return isinstance(count, int) and region[0] < count


def calibrated_content(case: Case) -> dict[str, Any]:
    """The content of a case, of which only that remains on which a calibration depends."""
    kept = {"assembly", "preload_N", "preload_ratios", "contact", "loss_factor", "damping"}
    block = {"resonance": 1, "joints": (measurement_of(case).joint,)}
    return {
        **case.model_dump(include=kept),
        "forces_N": (1.0,),
        "modes": (basis_of_measured(case),),
        "coordinates": ("linear",),
        "solve": (block,),
    }


def count_points(measured: Measured, files: StudyFiles) -> tuple[int, int]:
    """Numbers of points of all curves, fitted and predicted, of tables that can be read."""
    fitted, all_curves = (
        sum(table_of(curve, files.table(curve.file)).amplitude.size for _, curve in curves)
        for curves in (measured.fitted_curves, measured.all_curves)
    )
    return fitted, all_curves - fitted


def table_of(curve: MeasuredTable, text: str) -> BackboneTable | ResponseTable:
    """The points of a curve in the text of its file.

    Raises
    ------
    TableError
        As for ``read_backbone_table`` and ``read_response_table``.
    """
    read = read_response_table if isinstance(curve, MeasuredSteppedSine) else read_backbone_table
    return read(text, curve.file, curve.rows)


def conflicts_of_measured(
    case: Case, assembly: Described | None, settings: Settings | None, files: StudyFiles | None
) -> Problems:
    """What a case, its assembly, the settings and the files do not allow in its measurement.

    Without ``files``, none is read.
    """
    if case.measured is None:
        return
    for path, sentence in (
        *_conflicts_of_model(case, settings),
        *_conflicts_of_parameters(case, assembly),
        *_conflicts_of_sensors(case, assembly),
        *(() if files is None else _conflicts_of_files(case, files)),
    ):
        yield ("measured", *path), sentence


def _conflicts_of_model(case: Case, settings: Settings | None) -> Problems:
    """Joints and modes that the case does not have."""
    measured, basis = measurement_of(case), basis_of_measured(case)
    if basis not in case.bases:
        yield ("basis",), f"is none of the bases that are solved: {', '.join(case.bases)}"
        return
    joints = case.joints(basis)
    if measured.joint not in joints:
        sentence = f"is no joint that solve has in {basis}{choice(measured.joint, joints)}"
        yield ("joint",), sentence
    law = case.contact.declaration
    if not law.has_closed_form:
        sentence = f"must be left out with {law.name}: fits need a closed form of the law"
        yield ("joint",), sentence
    most, reason = basis.fewest, f"the modes of the basis {basis}"
    if basis.is_contact_adapted and settings is not None:
        adapted = settings.contact_adapted_basis.resonances
        if adapted < most:
            most, reason = adapted, f"contact_adapted_basis.resonances of {CONFIG_FILE}"
    for key, curve in measured.all_curves:
        if isinstance(curve, MeasuredCurve) and (curve.resonance or 0) > most:
            yield (*key, "resonance"), f"must be at most {most}, {reason}"


def _conflicts_of_parameters(case: Case, assembly: Described | None) -> Problems:
    """Parameters that are none, and bounds that reach beyond what the case allows."""
    measured = measurement_of(case)
    ratios, of_bolts = _ratios(measured), ratio_keys(measured, assembly)
    keys = [*calibrated_keys(case), *of_bolts]
    with_regions = [f"joint.regions[0].{key}" for key in OF_REGION]
    allowed = [
        *keys,
        *ratios,
        *(key for key in with_regions if _is_of_region(key, measured.joint)),
    ]
    if of_bolts and fits_preloads(measured) and not all(case.preload_ratios or (1.0,)):
        yield ("joint",), "must not fit preloads of a case with a bolt that has none"
        return
    for place, curve in measured.all_curves:
        for key, value in (curve.configuration or {}).items():
            at = (*place, "configuration", key)
            if key not in keys:
                yield at, f"is no key that is fitted{choice(key, keys)}"
                continue
            yield from ((at, sentence) for sentence in _refused_value(case, assembly, key, value))
    for key, parameter in measured.parameters.items():
        if key in ratios or _is_of_region(key, measured.joint):
            if parameter.low <= 0:
                yield ("parameters", key, "low"), "must be greater than 0: it is a ratio"
            continue
        if key not in keys:
            is_divided = key.startswith(RATIOS) and measured.joint != REFERENCE[0]
            of_joint = f"; preloads of bolts ask for joint: {REFERENCE[0]}"
            told = of_joint if is_divided else choice(key, allowed)
            yield ("parameters", key), f"is no key that is fitted{told}"
            continue
        if key == "preload_N" and (fixed := _fixed_loads(case, assembly)):
            yield ("parameters", key), f"must not be fitted {fixed}"
            continue
        for end in ("low", "high"):
            for sentence in _refused_value(case, assembly, key, getattr(parameter, end)):
                yield ("parameters", key, end), f"reaches too far: {sentence}"


def _fixed_loads(case: Case, assembly: Described | None) -> str:
    """What does not grow with the preload, in words; empty where all loads do."""
    if assembly is None or assembly.fixed_loads is None:
        return ""
    fixed, loads = assembly.fixed_loads
    return f"with {fixed} of {case.assembly}: {loads} do not grow with the preload"


def _refused_value(case: Case, assembly: Described | None, key: str, value: float) -> Iterator[str]:
    """What is wrong with another value of a key, fitted or of a configuration."""
    if key.startswith(RATIOS) and assembly is not None:
        if value <= 0:
            yield "must be greater than 0: it is a ratio"
            return
        own = {"preload_ratios": case.preload_ratios}
        content = with_all_ratios(own, [key], assembly.bolt_count)
        changed = with_value_at(content, path_of(key), value)["preload_ratios"]
        yield from (sentence for _, sentence in assembly.conflicts_of_ratios(changed))
        return
    if key == "preload_N" and (fixed := _fixed_loads(case, assembly)):
        yield f"must not differ {fixed}"
        return
    yield from refused(with_values(calibrated_content(case), {key: value}), Case)


def _conflicts_of_sensors(case: Case, assembly: Described | None) -> Problems:
    """Sensors that the case does not have."""
    names = [*(sensor.name for sensor in case.sensors), *case.outputs]
    if not names and assembly is not None:
        names = list(assembly.output_names)
    for key, curve in measurement_of(case).all_curves:
        if curve.sensor is not None and curve.sensor not in names:
            sentence = f"is no sensor of the case{choice(curve.sensor, names)}"
            yield (*key, "sensor"), sentence
        shape = isinstance(curve, MeasuredCurve) and curve.shape
        unknown = [sensor for sensor in shape or () if sensor not in names]
        if unknown:
            sentence = f"has {unknown[0]}, no sensor of the case{choice(unknown[0], names)}"
            yield (*key, "shape"), sentence


def _conflicts_of_files(case: Case, files: StudyFiles) -> Problems:
    """Tables that cannot be read, or that do not tell enough."""
    measured, values = measurement_of(case), 0
    for key, curve in measured.all_curves:
        try:
            table = table_of(curve, files.table(curve.file))
        except TableError as error:
            yield (*key, "file"), f"cannot be used: {error}"
            return
        except (OSError, UnsuitableFile) as error:
            problem = (
                error.sentence
                if isinstance(error, UnsuitableFile)
                else f"cannot be read ({error.strerror})"
            )
            yield (*key, "file"), f"{problem}: must be a CSV file, seen from the folder of config/"
            return
        compared = 2
        if isinstance(table, ResponseTable):
            problems = _conflicts_of_response(case, curve, table)
            compared -= getattr(curve, "phase_error_deg", None) is None
        else:
            problems = _missing_errors(curve, table)
        yield from (((*key, at), sentence) for at, sentence in problems)
        if key[0] != "predicted":
            values += compared * table.amplitude.size
        if not table.has_unit and not _is_scaled(curve, measured):
            own = f"{AMPLITUDE_SCALE}[{curve.label}]"
            parameter = AMPLITUDE_SCALE if key[0] == "predicted" else own
            yield (
                (*key, "file"),
                f"tells no unit of the {table.quantity}: its column must end in one, or parameters "
                f"must have {parameter}",
            )
    if values < (count := len(measured.parameters)):
        sentence = f"are {count}, more than the {values} measured values: must be at most as many"
        yield ("parameters",), sentence


def _missing_errors(curve: MeasuredTable, table: BackboneTable) -> Iterator[tuple[str, str]]:
    """Standard deviations that neither the file nor the case has."""
    for column, percent, std in (
        ("frequency_std_Hz", "frequency_error_percent", table.frequency_std),
        ("damping_ratio_std", "damping_error_percent", table.damping_std),
    ):
        if std is None and getattr(curve, percent) is None:
            yield percent, f"is missing: {curve.file} has no column {column}"


def _conflicts_of_response(
    case: Case, curve: MeasuredTable, table: ResponseTable
) -> Iterator[tuple[str, str]]:
    """An excitation of another kind than that of the case, and phases that are not there."""
    if (table.level_unit == "N") == case.is_base_excited:
        wanted = next(key for key, unit in LEVELS.items() if unit != table.level_unit)
        yield "file", f"has no column {wanted}: as the excitation of the case"
    if table.phase is None and getattr(curve, "phase_error_deg", None) is not None:
        yield "phase_error_deg", f"must be left out: {curve.file} has no phase_rad or phase_deg"


def _is_scaled(curve: MeasuredTable, measured: Measured) -> bool:
    own = f"{AMPLITUDE_SCALE}[{curve.label}]"
    return bool({AMPLITUDE_SCALE, own} & set(measured.parameters))
