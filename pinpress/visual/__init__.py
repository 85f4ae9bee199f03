"""Everything that a browser shows: charts, recordings, reports, films."""
