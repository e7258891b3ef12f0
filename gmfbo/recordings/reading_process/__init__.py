"""Read foreign files in another process, which a bad file may crash or hang.

`reading_process.read_apart` reads one file or raises `RecordingError`, `reading_process.try_apart`
says what can be read of a damaged one, and `reading_process.Reader` reads many.
"""
