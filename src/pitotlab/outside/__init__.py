"""A generator of flights that shares no code with the product, an oracle of its bounds, and the
judge of both.
"""
