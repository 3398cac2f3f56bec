"""Campaigns: many flights, sensed, calibrated, scored and kept."""
