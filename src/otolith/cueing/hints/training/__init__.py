"""Offline knowledge for the implicit MPC: hints are trained by simulation and judged on unseen problems."""
