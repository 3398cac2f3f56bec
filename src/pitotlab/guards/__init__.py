"""The guards: two checkouts, before and today, are asked the same questions, and each difference is
listed.
"""
