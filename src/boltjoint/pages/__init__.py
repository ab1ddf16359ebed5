"""The pages of the report: what they show, in which order, and how they are set."""
