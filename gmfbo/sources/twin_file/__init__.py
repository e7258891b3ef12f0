"""Read and write twin files, which tell an FMU in the recording's words.

`twin_file.TwinFile` is a validated file, and `twin_file.twin_files` lists those of a folder;
`column_file.column_mapping` reads a mapping of columns that several twin files share;
`toml_lines.toml_text` writes text, and `pydantic_message.describe_problems` words what is wrong.
"""
