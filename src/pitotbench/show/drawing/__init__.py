"""Draw the panels of a page as SVG, without a drawing library.

A campaign's page has more than a hundred panels of lines, bands and bars. matplotlib takes 0.1 s for each and 0.5 s
to load, which together is more than the flights take. Pictures with anything else (maps, logarithmic axes, files
for the docs) are drawn with matplotlib, in `show.style`.
"""
