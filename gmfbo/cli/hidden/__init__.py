"""The demo's hidden physics: drawn, sealed, recorded and, at the end, revealed.

`draw.draw` chooses the effects, `recordings.record` runs the plant that has them, `sealed.seal`
and `sealed.unseal` keep the answer, and `reveal.answer_lines` shows it beside the diagnosis.
The names and contents of the recordings say nothing of the draw.
"""
