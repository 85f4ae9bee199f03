"""The press on its springs: its bodies, the springs between them, and what else acts on them."""
