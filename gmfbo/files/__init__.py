"""Write files whole or not at all, read bounded TOML, remove private folders.

`durable.write_whole` survives a kill at any instant, and `durable.cause` words an OSError;
`toml_text.parse_toml` limits what a user's file may hold; `private_folder.PrivateFolder` is gone
once its owner has ended.
"""
