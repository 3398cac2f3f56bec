"""Commands of the command line, one a file: flags, one call to the bench, what is printed and written."""
