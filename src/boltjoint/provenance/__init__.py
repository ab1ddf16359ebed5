"""What the workflow needs besides the mechanics: code dependencies, logs and the environment."""
