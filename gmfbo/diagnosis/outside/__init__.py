"""Draw what is missing as a curve over one state.

`unknown_shape.shape_of` draws what no law holds, as it was fitted in place of laws, and
`named_law.inferred_beside_law` what recordings show beside a law that was named.
"""
