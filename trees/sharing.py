"""The inner loops of shared trees: nodes made once, found again by a hash table.

A node is one uint64, its low child in the high half and its high child in the low half. Nodes 0 and 1
are white and black; `nodes[0]` holds how many there are. The table has a slot for twice as many.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

ZERO = np.uint64(0)
ONE = np.uint64(1)
SIX = np.uint64(6)
HALF = np.uint64(32)
LOWER = np.uint64(0xFFFFFFFF)
FULL = np.uint64(0xFFFFFFFFFFFFFFFF)
NONE = np.uint64(0xFFFFFFFF)
SPREAD = np.uint64(0x9E3779B97F4A7C15)
MOST_NODES = 2**28


@no_type_check
@numba.njit(cache=True)
def new_nodes(room):
    """Room for some nodes, and an empty table."""
    size = 1024
    while size < room:
        size *= 2
    nodes = np.zeros(size, np.uint64)
    nodes[0] = np.uint64(2)
    return nodes, np.zeros(2 * size, np.uint32)


@no_type_check
@numba.njit(cache=True, inline="always")
def slot_of(key, mask):
    """Where the search for a key begins."""
    mixed = (key ^ (key >> np.uint64(29))) * SPREAD
    return (mixed ^ (mixed >> np.uint64(32))) & mask


@no_type_check
@numba.njit(cache=True)
def grown(nodes, table):
    """Twice the room. Raises OverflowError above 2^28 nodes."""
    if nodes.size >= MOST_NODES:
        raise OverflowError("too many nodes")
    more = np.zeros(2 * nodes.size, np.uint64)
    more[: nodes.size] = nodes
    wider = np.zeros(2 * table.size, np.uint32)
    mask = np.uint64(wider.size - 1)
    for i in range(2, int(nodes[0])):
        slot = slot_of(more[i], mask)
        while wider[slot] != 0:
            slot = (slot + ONE) & mask
        wider[slot] = i
    return more, wider


@no_type_check
@numba.njit(cache=True)
def node(nodes, table, low, high):
    """The node of these children: the one there is, or a new one. There must be room."""
    if low == high and low < np.uint64(2):
        return np.uint64(low)
    key = (np.uint64(low) << HALF) | np.uint64(high)
    mask = np.uint64(table.size - 1)
    slot = slot_of(key, mask)
    while table[slot] != 0:
        if nodes[table[slot]] == key:
            return np.uint64(table[slot])
        slot = (slot + ONE) & mask
    made = nodes[0]
    nodes[made] = key
    table[slot] = made
    nodes[0] = made + ONE
    return made


@no_type_check
@numba.njit(cache=True)
def loaded(nodes, table, lows, highs):
    """The nodes of another tree, entered: their new numbers."""
    names = np.empty(lows.size + 2, np.uint64)
    names[0], names[1] = ZERO, ONE
    for i in range(lows.size):
        if nodes[0] + ONE > nodes.size - 1:
            nodes, table = grown(nodes, table)
        names[i + 2] = node(nodes, table, names[lows[i]], names[highs[i]])
    return nodes, table, names


@no_type_check
@numba.njit(cache=True)
def numbered(nodes, root):
    """Children of the nodes below the root, each after its children, the low child's nodes first."""
    if root < np.uint64(2):
        return np.zeros(0, np.uint32), np.zeros(0, np.uint32)
    names = np.zeros(nodes[0], np.uint32)
    names[1] = 1
    lows, highs = np.empty(nodes[0], np.uint32), np.empty(nodes[0], np.uint32)
    stack = np.empty(1024, np.uint64)
    stack[0] = root
    depth, n = 1, 0
    while depth > 0:
        top = stack[depth - 1]
        low, high = nodes[top] >> HALF, nodes[top] & LOWER
        if low > ONE and names[low] == 0:
            stack[depth] = low
            depth += 1
        elif high > ONE and names[high] == 0:
            stack[depth] = high
            depth += 1
        else:
            lows[n], highs[n] = names[low], names[high]
            names[top] = n + 2
            n += 1
            depth -= 1
    return lows[:n].copy(), highs[:n].copy()


@no_type_check
@numba.njit(cache=True, inline="always")
def settled(operation, a, b):
    """The result where it is known at once; operation 0 is or, 1 and, 2 exclusive or, 3 and not."""
    if operation == 0:
        if a == ONE or b == ONE:
            return ONE
        return b if a == ZERO else (a if b == ZERO or a == b else NONE)
    if operation == 1:
        if a == ZERO or b == ZERO:
            return ZERO
        return b if a == ONE else (a if b == ONE or a == b else NONE)
    if a == b:
        return ZERO
    if b == ZERO:
        return a
    if operation == 2:
        if a == ZERO:
            return b
        return ONE if a + b == ONE else NONE
    return ZERO if a == ZERO or b == ONE else NONE


@no_type_check
@numba.njit(cache=True)
def combined(nodes, table, a, b, operation):
    """Two nodes combined; every pair of nodes is worked out once."""
    keys, values = np.zeros(4096, np.uint64), np.zeros(4096, np.uint32)
    held = 0
    left, right = np.empty(1024, np.uint64), np.empty(1024, np.uint64)
    stage, first = np.zeros(1024, np.uint8), np.empty(1024, np.uint64)
    left[0], right[0] = a, b
    depth, found = 1, ZERO
    while depth > 0:
        i = depth - 1
        x, y = left[i], right[i]
        if stage[i] == 0:
            found = settled(operation, x, y)
            if found != NONE:
                depth -= 1
                continue
            if operation < 3 and x > y:
                x, y = y, x
                left[i], right[i] = x, y
            mask = np.uint64(keys.size - 1)
            key = (x << HALF) | y
            slot = slot_of(key, mask)
            while keys[slot] != ZERO and keys[slot] != key:
                slot = (slot + ONE) & mask
            if keys[slot] == key:
                found = np.uint64(values[slot])
                depth -= 1
                continue
        elif stage[i] == 1:
            first[i] = found
        else:
            if nodes[0] + ONE > nodes.size - 1:
                nodes, table = grown(nodes, table)
            found = node(nodes, table, first[i], found)
            if 2 * (held + 1) > keys.size:
                keys, values = wider(keys, values)
            remember(keys, values, (x << HALF) | y, found)
            held += 1
            stage[i] = 0
            depth -= 1
            continue
        left[depth], right[depth] = child(nodes, x, stage[i]), child(nodes, y, stage[i])
        stage[depth] = 0
        stage[i] += 1
        depth += 1
    return nodes, table, found


@no_type_check
@numba.njit(cache=True, inline="always")
def child(nodes, x, side):
    """The low child for side 0, the high one for side 1; a leaf's children have its colour."""
    if x < np.uint64(2):
        return x
    return nodes[x] >> HALF if side == 0 else nodes[x] & LOWER


@no_type_check
@numba.njit(cache=True)
def remember(keys, values, key, value):
    """Enter a key that is not there."""
    mask = np.uint64(keys.size - 1)
    slot = slot_of(key, mask)
    while keys[slot] != ZERO:
        slot = (slot + ONE) & mask
    keys[slot], values[slot] = key, value


@no_type_check
@numba.njit(cache=True)
def wider(keys, values):
    """A memory of twice the size. Raises OverflowError above 2^29 pairs."""
    if keys.size >= 2 * MOST_NODES:
        raise OverflowError("too many pairs of nodes")
    more_keys, more_values = np.zeros(2 * keys.size, np.uint64), np.zeros(2 * keys.size, np.uint32)
    for i in range(keys.size):
        if keys[i] != ZERO:
            remember(more_keys, more_values, keys[i], values[i])
    return more_keys, more_values


@no_type_check
@numba.njit(cache=True)
def octets(nodes, table):
    """The nodes of the 256 sets of eight cells."""
    made = np.empty(256, np.uint64)
    for byte in range(256):
        a = np.empty(8, np.uint64)
        for i in range(8):
            a[i] = np.uint64((byte >> i) & 1)
        for width in (4, 2, 1):
            for i in range(width):
                a[i] = node(nodes, table, a[2 * i], a[2 * i + 1])
        made[byte] = a[0]
    return made


@no_type_check
@numba.njit(cache=True)
def of_word(nodes, table, eights, word, height):
    """The node of the lowest `2^height` bits of a word."""
    if height < 6:
        a = np.empty(32, np.uint64)
        for i in range(1 << height):
            a[i] = (word >> np.uint64(i)) & ONE
        for level in range(height):
            for i in range(1 << (height - 1 - level)):
                a[i] = node(nodes, table, a[2 * i], a[2 * i + 1])
        return a[0]
    b = np.empty(8, np.uint64)
    for i in range(8):
        b[i] = eights[(word >> np.uint64(8 * i)) & np.uint64(255)]
    for width in (4, 2, 1):
        for i in range(width):
            b[i] = node(nodes, table, b[2 * i], b[2 * i + 1])
    return b[0]


@no_type_check
@numba.njit(cache=True)
def of_bricks(starts, words, bricks, depth):
    """The nodes of a tree of bricks, and its root; depth is that of the whole binary tree."""
    nodes, table = new_nodes(4096)
    eights = octets(nodes, table)
    top = max(depth - 6, 0)
    pending = np.zeros(top + 1, np.uint64)
    open_node, open_key, height = ZERO, ZERO, -1
    for i in range(starts.size):
        word = words[i]
        if word == ZERO:
            continue
        if nodes[0] + np.uint64(200) > nodes.size:
            nodes, table = grown(nodes, table)
        made = of_word(nodes, table, eights, word, min(depth, 6))
        stop = starts[i + 1] if i + 1 < starts.size else bricks
        key = starts[i]
        while key < stop:
            n, raised = 0, made
            while n < top and (key >> np.uint64(n)) & ONE == ZERO and key + (ONE << np.uint64(n + 1)) <= stop:
                raised = node(nodes, table, raised, raised)
                n += 1
            if height >= 0:
                until = highest_bit(open_key ^ key)
                pending[until] = lifted(nodes, table, pending, open_key, open_node, height, until)
            open_node, open_key, height = raised, key, n
            key += ONE << np.uint64(n)
            if nodes[0] + np.uint64(400) > nodes.size:
                nodes, table = grown(nodes, table)
    if height < 0:
        return nodes, ZERO
    return nodes, lifted(nodes, table, pending, open_key, open_node, height, top)


@no_type_check
@numba.njit(cache=True)
def lifted(nodes, table, pending, key, made, height, until):
    """A node and the pending ones on its left, as one node at the height `until`."""
    while height < until:
        if (key >> np.uint64(height)) & ONE == ONE:
            made = node(nodes, table, pending[height], made)
            pending[height] = ZERO
        else:
            made = node(nodes, table, made, ZERO)
        height += 1
    return made


@no_type_check
@numba.njit(cache=True, inline="always")
def highest_bit(x):
    """The place of the highest bit of a number above 0."""
    place = 0
    while x > ONE:
        x >>= ONE
        place += 1
    return place


@no_type_check
@numba.njit(cache=True)
def of_digits(digits):
    """The nodes of sorted, different cells, and the root: `digits[i]` is the path of cell i, 0 or 1 each."""
    nodes, table = new_nodes(4096)
    count, depth = digits.shape
    pending = np.zeros(depth + 1, np.uint64)
    for i in range(count):
        until = depth
        if i + 1 < count:
            same = 0
            while digits[i, same] == digits[i + 1, same]:
                same += 1
            until = depth - 1 - same
        if nodes[0] + np.uint64(depth + 8) > nodes.size:
            nodes, table = grown(nodes, table)
        made = ONE
        for height in range(until):
            if digits[i, depth - 1 - height] == 1:
                made = node(nodes, table, pending[height], made)
                pending[height] = ZERO
            else:
                made = node(nodes, table, made, ZERO)
        pending[until] = made
    return nodes, pending[depth] if count > 0 else ZERO


@no_type_check
@numba.njit(cache=True)
def to_bricks(lows, highs, root, depth, most):
    """Starts and words of a shared tree. Raises OverflowError above `most` entries."""
    starts, words = np.empty(1024, np.uint64), np.empty(1024, np.uint64)
    known = np.zeros(lows.size + 2, np.uint8)
    word_of = np.zeros(lows.size + 2, np.uint64)
    base = min(depth, 6)
    stack, heights, keys = np.empty(512, np.uint64), np.empty(512, np.int64), np.empty(512, np.uint64)
    stack[0], heights[0], keys[0] = np.uint64(root), depth, ZERO
    depth_now, n = 1, 0
    while depth_now > 0:
        depth_now -= 1
        x, height, key = stack[depth_now], heights[depth_now], keys[depth_now]
        inner, down = x, height
        while inner > ONE and down > base and lows[inner - 2] == highs[inner - 2]:
            inner = np.uint64(lows[inner - 2])
            down -= 1
        if inner > ONE and down > base:
            inner, down = x, height
            half = np.uint64(height - 1)
            stack[depth_now], heights[depth_now] = np.uint64(highs[x - 2]), height - 1
            keys[depth_now] = key + (ONE << (half - np.uint64(base)))
            stack[depth_now + 1], heights[depth_now + 1] = np.uint64(lows[x - 2]), height - 1
            keys[depth_now + 1] = key
            depth_now += 2
            continue
        if inner <= ONE:
            word = ZERO if inner == ZERO else FULL >> np.uint64(64 - (1 << base))
        else:
            if known[inner] == 0:
                word_of[inner] = word_below(lows, highs, inner, base)
                known[inner] = 1
            word = word_of[inner]
        if n > 0 and words[n - 1] == word:
            continue
        if n == starts.size:
            if n >= most:
                raise OverflowError("too many bricks")
            starts = np.concatenate((starts, np.empty(n, np.uint64)))
            words = np.concatenate((words, np.empty(n, np.uint64)))
        starts[n], words[n] = key, word
        n += 1
    return starts[:n].copy(), words[:n].copy()


@no_type_check
@numba.njit(cache=True)
def word_below(lows, highs, x, height):
    """The word of a node at this height, at most 6."""
    a = np.empty(64, np.uint64)
    a[0] = x
    for level in range(height):
        for i in range((1 << level) - 1, -1, -1):
            y = a[i]
            if y > ONE:
                a[2 * i + 1], a[2 * i] = np.uint64(highs[y - 2]), np.uint64(lows[y - 2])
            else:
                a[2 * i + 1], a[2 * i] = y, y
    word = ZERO
    for i in range(1 << height):
        word |= a[i] << np.uint64(i)
    return word


@no_type_check
@numba.njit(cache=True)
def shares(lows, highs):
    """The black part of each node, in units of `2^-63`: exact for trees of at most 63 levels."""
    parts = np.empty(lows.size + 2, np.uint64)
    parts[0], parts[1] = ZERO, ONE << np.uint64(63)
    for i in range(lows.size):
        parts[i + 2] = (parts[lows[i]] + parts[highs[i]]) >> ONE
    return parts


@no_type_check
@numba.njit(cache=True)
def holds(lows, highs, root, cells, bits):
    """Which cells `(n, k)` are black."""
    n, k = cells.shape
    found = np.zeros(n, np.bool_)
    for i in range(n):
        x = np.uint64(root)
        for bit in range(bits - 1, -1, -1):
            for axis in range(k):
                if x > ONE:
                    upper = (cells[i, axis] >> np.uint64(bit)) & ONE
                    x = np.uint64(highs[x - 2] if upper == ONE else lows[x - 2])
        found[i] = x == ONE
    return found
