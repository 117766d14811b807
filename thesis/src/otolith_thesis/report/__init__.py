"""The reproduction as a page: one HTML file from plain values, with a style sheet for screen and paper."""
