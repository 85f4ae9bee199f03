"""Everything one looks at in a browser: charts, recordings, reports, films."""
