"""The page of `pitotbench open` for one person on this computer: drop a log, see the answer."""
