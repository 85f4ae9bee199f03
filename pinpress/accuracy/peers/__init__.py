"""The same press in other programs, whose answers and run times are set beside those of pinpress.

Nothing of theirs is imported before it is asked for.
"""
