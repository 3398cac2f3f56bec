"""The blind test of reconcile: logs with hidden causes, judged by the product, scored against a
sealed truth.
"""
