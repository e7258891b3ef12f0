"""Read FMU archives safely, and describe a run of wired FMUs as a job.

`description.read_description` reads an `description.FmuDescription` without running any code;
`unpacking.unpack` opens the archive; `job.Job` tells what is set, stepped and read, and
`job.Outcome` what came of it. `models.models_folder` is where the project's own FMUs lie.
"""
