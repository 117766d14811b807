"""How much was compiled: a number that must not grow while a platform is armed."""

import gc

from numba.core.dispatcher import Dispatcher


def compiled() -> int:
    """Return how many functions numba has compiled, or loaded, for how many kinds of arguments.

    A growing number while armed is a decision or a set-point that waited for the compiler, or for its cache.
    """
    # isinstance would ask what a weak reference refers to, which may be gone
    return sum(len(one.overloads) for one in gc.get_objects() if issubclass(type(one), Dispatcher))
