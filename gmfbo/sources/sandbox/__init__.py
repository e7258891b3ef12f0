"""Sandbox that keeps FMUs from the user's files, network and programs.

On Linux the process that runs FMUs shuts itself in before it loads any foreign code: `landlock`
limits the files that it may open, `seccomp` its system calls, and `limits` its resources;
`policy` holds the rights that the user grants. All of this is inherited and irrevocable. These
modules need the standard library only, since they work before NumPy is loaded.
"""
