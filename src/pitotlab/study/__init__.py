"""The simulator study of Martos, Kiszely and Foster (2011), flown again: every claim, and what it
left open.
"""
