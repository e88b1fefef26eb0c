"""Many problems: studies, processes, reports."""
