"""One derivative of an airplane's file is changed by hand; reconcile, which has the unchanged file, is to name it."""
