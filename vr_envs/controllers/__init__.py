"""Policies that need no training: observation batch -> action batch."""
