"""The same press in other programs, whose answers and run times are set beside those of pinpress.

Other programs are imported only when a peer is made.
"""
