"""What a scene does not need: each option's cost on and off, counted and timed, and what else is skipped."""
