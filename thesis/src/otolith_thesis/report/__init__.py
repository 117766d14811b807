"""The reproduction as a page: plain values in, one HTML file out; its style sheet serves screen and paper."""
