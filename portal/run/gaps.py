"""Fills the gaps between loaded objects before a fork, so that forks put what they allocate on pages of their own.

Loading modules leaves thousands of free blocks between the objects that stay. A fork that used these would write to
nearly every page of its parent, and the kernel would copy each: 2 MB of gaps cost 40 MB in ten processes. So the parent
takes them all and never gives them back. With other C libraries than glibc nothing happens.
"""

import contextlib
import ctypes

LARGEST, LEAST = 60_000, 24  # bytes of a block; larger ones are mapped apart


def fill() -> None:
    """Take every free block of the heap; called once, before the fork."""
    with contextlib.suppress(AttributeError):  # another C library
        _fill(ctypes.CDLL(None))


def _fill(libc: ctypes.CDLL) -> None:
    malloc, free, trim, end_of_heap = libc.malloc, libc.free, libc.malloc_trim, libc.sbrk
    malloc.restype = end_of_heap.restype = ctypes.c_void_p
    malloc.argtypes, free.argtypes, end_of_heap.argtypes = [ctypes.c_size_t], [ctypes.c_void_p], [ctypes.c_ssize_t]
    trim(0)
    end, size = end_of_heap(0), LARGEST
    while size >= LEAST:
        block = malloc(size)
        if not block or block >= end:  # beyond the old end: no gap is left of this size
            free(block)
            size = size * 15 // 16
