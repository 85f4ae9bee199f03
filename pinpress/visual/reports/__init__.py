"""Reports: pages of charts and tables next to a press that moves with them. `report` writes one, other modules make its sections."""
