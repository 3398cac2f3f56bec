"""Experiments over many flights that prove the product, and their pages. The product never imports this package."""
