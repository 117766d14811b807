// Written by a test from otolith/commander/frames.py.
export const MAGIC = "OTLC";
export const VERSION = 1;
export const PROTOCOL = "otolith.1";
export const WINDOW = 3;
export const KIND = {ENVELOPE: 1, RAW: 2};
export const HEADER_BYTES = 36;
export const AT = {version: 4, kind: 6, sequence: 8, t0: 12, age: 20, rows: 28, columns: 32, decimation: 34};
