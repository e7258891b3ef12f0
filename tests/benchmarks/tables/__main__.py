"""Write the tables of README and of the benchmarks' pages: `python -m tests.benchmarks.tables`."""

from __future__ import annotations

from tests.benchmarks.tables.written import write

if __name__ == "__main__":
    print("\n".join(f"{name}: written anew" for name in write()) or "all tables are as they were")
