"""What a fresh interpreter loads."""

import subprocess
import sys


def modules_loaded_by(statement):
    """Names of the modules that are there after a statement in a fresh interpreter."""
    program = f"import sys\n{statement}\nprint(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    return set(done.stdout.split())
