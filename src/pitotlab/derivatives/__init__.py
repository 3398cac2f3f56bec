"""A derivative in an airplane's file is changed; reconcile, which has the unchanged file, is to
name it.
"""
