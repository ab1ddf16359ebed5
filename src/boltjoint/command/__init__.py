"""The command ``boltjoint``: thin calls of the workflow and the library."""
