"""Keep a study's trials and events on disk, safe from kills and unseen damage.

`study_folder.StudyStore` writes a folder with a `trial.Trial` a file under one
`writer_lock.WriterLock`; `study_reading.FolderReading` reads it, `pack.pack_study` makes it one
HDF5 file, and `memory_store.MemoryStore` holds a study in memory. `events.read_events` reads the
log, and `trial_file.read_trial_file` one trial.
"""
