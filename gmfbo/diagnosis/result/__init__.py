"""The result of a diagnosis as frozen values, with its sentence, summary and JSON.

`findings.Findings` holds all of it, among others each `named_effect.NamedEffect`, the
`whereabouts.Location` of the mismatch and the errors before and after (`held_out_errors.Fit`).
`sentence.verdict_sentence` and `summary.summary_text` say it in words, and
`diagnosis_json.diagnosis_text` and `diagnosis_json.read_diagnosis` write and read it.
"""
