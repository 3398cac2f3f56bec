"""Drills of campaigns: what they survive, and what they cost."""
