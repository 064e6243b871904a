"""The moving scene in a browser: one page for recorded runs, saved or served, and a live one.

The page itself, `page.html`, is built from `web/` and committed, so that nothing is built or fetched
when the package is installed or a page is opened.
"""
