"""Damage done to files: to their bytes at random, or to their content with digests that are right again."""

from __future__ import annotations

import copy

import numpy as np

import roughcontact as rc
from unit_files import SEAL, digest_of, key_of_description, pack, seal, write_archive


def damage_bytes(data, rng):
    """Return bytes with flipped bits, a cut, or an inserted, zeroed, repeated or random block."""
    changed = bytearray(data)
    start = int(rng.integers(len(data)))
    length = int(min(rng.integers(1, 10 ** rng.integers(1, 5)), len(data)))
    block = bytes(rng.integers(0, 256, length, dtype=np.uint8))
    kind = rng.choice(["bits", "cut off", "cut out", "inserted", "zeroed", "repeated", "random", "appended"])
    if kind == "bits":
        for place in rng.integers(len(data), size=rng.integers(1, 9)):
            changed[place] ^= 1 << int(rng.integers(8))
    elif kind == "cut off":
        del changed[start:]
    elif kind == "cut out":
        del changed[start : start + length]
    elif kind == "zeroed":
        changed[start : start + length] = bytes(len(changed[start : start + length]))
    elif kind == "random":
        changed[start : start + length] = block[: len(changed[start : start + length])]
    else:
        place = len(changed) if kind == "appended" else start
        changed[place:place] = changed[start : start + length] if kind == "repeated" else block
    return bytes(changed)


# What may stand anywhere in a header instead of what stood there.
ODD = [
    None, True, False, "", "x", "free", "periodic", "love", "CONVERGED", "roughcontact:Grid", 0, -1, 1, 2, 10**9,
    10**30, 0.0, -0.5, 1e-300, 1e-12, 1.0, 1e12, 1e300, {"number": "nan"}, {"number": "inf"}, {"number": "-inf"},
    [], {}, [1.0, 2.0], {"mapping": {}}, {"array": "0" * 32}, {"kind": "surface", "name": "flat", "fields": {}},
]  # fmt: skip


def places_in(node, place=()):
    """Yield the place of every value in a header, inner ones as well."""
    if place:
        yield place
    for key, item in node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ():
        yield from places_in(item, (*place, key))


def value_at(node, place):
    for key in place:
        node = node[key]
    return node


def forge_header(arrays, header, other, rng):
    """Change a value of a header, take one from the header of another file, or leave it out."""
    places = [place for place in places_in(header) if place[0] not in ("key", "arrays")]
    place = places[rng.integers(len(places))]
    parent, key, old = value_at(header, place[:-1]), place[-1], value_at(header, place)
    kind = rng.choice(["odd", "scaled", "other", "dropped", "moved"])
    if kind == "scaled" and isinstance(old, (int, float)) and not isinstance(old, bool):
        # A new number must differ by more than rounding.
        factor = rng.choice([-1.0, 0.0, 0.5, 2.0, 7.0, 1.0 + 1e-5, 10.0 ** rng.integers(-30, 30)])
        parent[key] = int(old * factor) if isinstance(old, int) and rng.random() < 0.7 else float(old * factor)
    elif kind == "dropped":
        del parent[key]
    elif kind == "other":
        header[place[0]] = other[1].get(place[0])
    else:
        odd = ODD[rng.integers(len(ODD))] if kind == "odd" else value_at(header, places[rng.integers(len(places))])
        parent[key] = copy.deepcopy(odd)


def _change_values(values, rng):
    flat = np.array(values, dtype=np.float64).ravel()
    place = int(rng.integers(max(flat.size, 1)))
    largest = float(np.nanmax(np.abs(flat), initial=0.0)) or 1.0
    kind = rng.choice(["scaled", "one", "rolled", "nan", "inf", "negated", "zero", "shifted", "noise"])
    if kind == "scaled":
        flat *= rng.choice([7.0, 0.5, 1.0 + 1e-5, 1e30, 1e-30])
    elif kind == "rolled":
        flat = np.roll(flat, 1)
    elif kind == "negated":
        flat = -flat
    elif kind == "shifted":
        flat += 1e-3 * largest
    elif kind == "noise":
        flat += 1e-4 * largest * rng.standard_normal(flat.size)
    else:
        flat[place : place + 1] = {"nan": np.nan, "inf": np.inf, "zero": 0.0}.get(kind, 1e-3 * largest)
    return flat.reshape(np.shape(values))


def forge_arrays(arrays, header, other, rng):
    """Change the values, the type, the shape or the name of an array; take it from another file, or leave it out."""
    name = sorted(arrays)[rng.integers(len(arrays))]
    values = arrays[name]
    kind = rng.choice(["values", "values", "values", "type", "shape", "other", "dropped", "added", "swapped"])
    if kind == "values" and values.dtype.kind == "f":
        arrays[name] = _change_values(values, rng)
    elif kind == "type":
        arrays[name] = np.clip(np.nan_to_num(values), -1e9, 1e9).astype(rng.choice(["f4", "i8", "u1", "?", "U4"]))
    elif kind == "shape":
        arrays[name] = [values.ravel(), values.T, np.atleast_1d(values)[..., :1], values[None], values.ravel()[:0]][
            rng.integers(5)
        ]
    elif kind == "other":
        arrays[name] = other[0].get(name, np.ones(3))
    elif kind == "dropped":
        del arrays[name]
    elif kind == "added":
        arrays["more"] = values
    else:
        second = sorted(arrays)[rng.integers(len(arrays))]
        arrays[name], arrays[second] = arrays[second], arrays[name]


def forge_together(arrays, header, other, rng):
    """Change one thing, and all else that would contradict it without a convolution."""
    kind = rng.choice(["all", "pressure", "displacement", "approach", "heights", "problem", "gap", "residuals"])
    factor = float(rng.choice([7.0, 0.5, 1.0 + 1e-5]))
    if kind in ("all", "pressure"):
        for name in ("pressure", "force", "mean_pressure", "maximum_pressure"):
            arrays[name] = arrays[name] * factor
        header["load"] = {"mapping": {"force": float(arrays["force"])}}
    if kind in ("all", "displacement"):
        arrays["displacement"] = arrays["displacement"] * factor
    if kind == "approach":
        header["approach"] *= factor
    if kind == "gap":
        arrays["initial_gap"] = arrays["initial_gap"] * factor
    if kind == "residuals":
        # A state that is not an equilibrium, with the residuals of one.
        arrays["pressure"] = np.roll(arrays["pressure"], 1, axis=int(rng.integers(2)))
    if kind == "problem":
        header["problem"], header["load"] = other[1]["problem"], other[1]["load"]
        arrays.update({name: values for name, values in other[0].items() if name.startswith("part_")})
    parts = sorted(name for name in arrays if name.startswith("part_"))
    if kind == "heights" and parts:
        old = parts[rng.integers(len(parts))]
        new = arrays.pop(old) * factor if rng.random() < 0.5 else np.roll(other[0]["initial_gap"], 1)
        arrays[f"part_{digest_of(new)}"] = new
        _rename(header, old.removeprefix("part_"), digest_of(new))
    if arrays["initial_gap"].shape == arrays["displacement"].shape:
        arrays["gap"] = arrays["initial_gap"] + arrays["displacement"] - header["approach"]


def _rename(node, old, new):
    for place in list(places_in(node)):
        if value_at(node, place) == old:
            value_at(node, place[:-1])[place[-1]] = new


def forge(content, other, rng):
    """Return the arrays and the header of a solution's file, one of them changed; with another key at times."""
    arrays, header = {**content[0]}, copy.deepcopy(content[1])
    (forge_header, forge_arrays, forge_together)[rng.integers(3)](arrays, header, other, rng)
    kind = rng.choice(["kept", "none", "none", "right", "right", "right", "other"])
    if kind == "none":
        header["key"] = ""
    if kind == "other":
        header["key"] = other[1]["key"]
    if kind == "right":
        header["key"] = right_key(header)
    return arrays, header


def right_key(header):
    """Return the key that a header should have; its own where it has no key."""
    try:
        problem = key_of_description({"mapping": header["problem"]["fields"]}, *header["programs"])
        made_by = (f"{name} {number}" for name, number in header["versions"].items() if name != "python")
        return key_of_description([problem, header["load"]], *made_by)
    except (KeyError, TypeError, AttributeError, rc.InputError):
        return header.get("key", "")


def write_forged(path, arrays, header):
    """Write a file with right digests; `InputError` if even that cannot be."""
    if path.suffix == ".npz":
        write_archive(path, arrays, header)
        return
    import h5py

    with h5py.File(path, "w") as file:
        # Its status is text, which only npz files hold.
        for name, values in pack({name: arrays[name] for name in arrays if name != "status"}, header).items():
            file[name] = values.astype(np.int8) if values.dtype == bool else values
            if values.dtype == bool:
                file[name].attrs["dtype"] = np.bytes_(b"bool")
    with path.open("ab") as stream:
        stream.write(SEAL)
    seal(path)
