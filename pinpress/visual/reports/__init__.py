"""Reports: pages of charts and tables beside a press that moves with them. `report` writes one, other modules make its sections."""
