"""The live window: a press in the browser that moves while its lengths, its pivots and its speed are changed."""
