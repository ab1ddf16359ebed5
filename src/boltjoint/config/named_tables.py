"""Tables that a study names: designs of sweeps and maps of gaps, with problems noted."""

from collections.abc import Mapping

from boltjoint.config.csv_table import TableError
from boltjoint.config.described import Described
from boltjoint.config.files import StudyFiles
from boltjoint.config.gap_map import GapMap, read_gap_map
from boltjoint.config.strict_yaml import as_text, as_word
from boltjoint.config.swept_designs import SweptDesigns
from boltjoint.config.types import ASSEMBLY_FOLDER
from boltjoint.regular_file import UnsuitableFile


def check_table(designs: SweptDesigns, files: StudyFiles) -> None:
    """Note what is wrong with a table of designs."""
    file = designs.file
    try:
        _ = designs.columns
    except OSError as error:
        files.problems.append(f"{as_word(file)}: cannot be read: {error.strerror}")
    except UnsuitableFile as error:
        files.problems.append(f"{as_word(file)}: {error.sentence}")
    except TableError as error:
        files.problems.append(str(error))


def read_gap_maps(
    assemblies: Mapping[str, Described | None], files: StudyFiles
) -> dict[str, GapMap]:
    """The maps of gaps by their files; those that cannot be read are noted."""
    found = {}
    for name, assembly in assemblies.items():
        file = None if assembly is None else assembly.gap_file
        if file is None:
            continue
        try:
            found[file] = read_gap_map(files.table(file), file)
            continue
        except TableError as error:
            sentence = str(error)
        except (OSError, UnsuitableFile) as error:
            if isinstance(error, UnsuitableFile):
                problem = error.sentence
            else:
                problem = f"cannot be read ({error.strerror})"
            sentence = f"{as_text(file)} {problem}: must be a CSV file"
            sentence += ", seen from the folder of config/"
        files.note(f"{ASSEMBLY_FOLDER}/{name}.yaml", [(("contact", "gap_um"), sentence)])
    return found
