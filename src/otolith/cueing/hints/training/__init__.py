"""Offline knowledge for the implicit MPC: train hints by simulation, judge them on what they never saw."""
