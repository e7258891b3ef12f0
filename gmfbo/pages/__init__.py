"""Build self-contained HTML pages with SVG charts and marked numbers.

`html_page.page` makes the page of `html_page.section` and `html_page.table`, every value
escaped; `svg_chart.line_chart` and `shaded_map.shaded_cells` draw, `signal_panel.panel_figures` a
recorded signal with its simulations; `marked_number.marked_number` writes a number with its place
in the page's JSON; `thinning.thinned_rows` leaves out points.
"""
