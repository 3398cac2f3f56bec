"""The whole workflow: reconcile a log, look again with what was named, fly its card again, write it down."""
