"""``python -m boltjoint``, the same as the command ``boltjoint``."""

import sys

from boltjoint.command.main import main

if __name__ == "__main__":
    sys.exit(main())
