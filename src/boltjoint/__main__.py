"""``python -m boltjoint``, the same as the command ``boltjoint``."""

import sys

from boltjoint.command.main import main

sys.exit(main())
