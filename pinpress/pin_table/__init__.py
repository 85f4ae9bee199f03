"""Pin tables: presses as engineers draw them, with pins, links and masses in a YAML file or a call.

press = pp.build("press.yaml", r=150)
draft = pp.pin_table.draft("press.yaml", r=150)
Path("press.svg").write_text(draft.sketch)
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
