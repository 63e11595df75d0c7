"""Readers and writers: one file a format, and the manifest of a campaign."""
