"""The contact-adapted basis: candidates, snapshots and their proper orthogonal decomposition."""
