"""Reports: pages of charts and tables next to a moving press. `report` writes a report; the other modules make its sections."""
