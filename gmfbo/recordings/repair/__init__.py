"""Repair damaged studies: damaged files are mended or set aside, others kept.

`repair_folder.repair_folder` repairs a study folder, and `repair_packed.repair_packed` makes a
folder of a damaged packed study.
"""
