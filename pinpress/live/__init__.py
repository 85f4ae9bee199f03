"""The live window: a moving press in the browser whose lengths, pivots and speed can be changed."""
