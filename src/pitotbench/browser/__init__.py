"""The page of `pitotbench open`: drop a log, brush minutes, see the answer.

For one person, on this computer alone.
"""
