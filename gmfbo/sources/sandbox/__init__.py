"""What keeps an FMU from the user's files, network and programs while it runs.

On Linux the process that runs FMUs shuts itself in before it loads any foreign code: `landlock`
limits what it may open, `seccomp` what it may ask the kernel for, `limits` how much it may use;
`policy` is what the user lets it have. All of it is inherited and cannot be taken back. These
modules need the standard library only, since they work before NumPy is loaded.
"""
