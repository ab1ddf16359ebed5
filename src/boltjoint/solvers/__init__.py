"""Newton's method and arc-length continuation of any system of equations with one parameter."""
