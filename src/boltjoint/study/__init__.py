"""What a study consists of on disk, and the tables made of it."""
