"""Tables 2 and 3 of Kong 2025 beside ours, as the Markdown table in the README; all of its tables and figures are in docs/kong2025.md.

python viz/kong2025.py
"""

from pinpress.reproduce.kong2025 import reactions_table as table

if __name__ == "__main__":
    print(table())
