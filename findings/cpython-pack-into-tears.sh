#!/bin/sh
# CPython 3.11: struct.pack_into sets all bytes to zero before it writes, so shared memory shows numbers nobody wrote.
#
# One process stores only two numbers, in turns, in an aligned word of 8 bytes of multiprocessing.shared_memory; another
# reads the word in one go. Stored by `struct.Struct("<Q").pack_into`, a few per cent of the looks find 0; the native
# format "@Q", which one expects to be a plain assignment, shows the same. A counter that says "there is something
# new" then runs backwards now and then. Stored through `memoryview.cast("Q")`, the same word is never seen half written.
#
# Run by hand, on a machine with two processors. Exits 0 while this holds, 1 once it does not.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat > "$folder/look.py" <<'PYTHON'
import multiprocessing
import struct
import sys
from multiprocessing import shared_memory

STORED = (0x0101010101010101, 0x0101010101010102)


def store(name, how):
    memory = shared_memory.SharedMemory(name)
    if how == "cast":
        words = memory.buf.cast("Q")
        for k in range(2_000_000):
            words[1] = STORED[k & 1]
        words.release()
    else:
        word = struct.Struct(how)
        for k in range(2_000_000):
            word.pack_into(memory.buf, 8, STORED[k & 1])
    memory.close()


def look(how):
    memory = shared_memory.SharedMemory(create=True, size=64)
    words = memory.buf.cast("Q")
    words[1] = STORED[0]
    writer = multiprocessing.get_context("spawn").Process(target=store, args=(memory.name, how))
    writer.start()
    looks, odd, seen = 0, 0, set()
    while writer.is_alive():
        for _ in range(1_000):
            word = words[1]
            looks += 1
            if word not in STORED:
                odd += 1
                seen.add(word)
    writer.join()
    words.release()
    memory.close()
    memory.unlink()
    print(f"{how}: {looks} looks, {odd} at a number that nobody stored: {sorted(seen)[:3]}")
    return odd


if __name__ == "__main__":
    print("Python", sys.version.split()[0])
    packed = [look("<Q"), look("@Q")]
    sys.exit(0 if min(packed) > 0 and look("cast") == 0 else 1)
PYTHON
python3 "$folder/look.py"
