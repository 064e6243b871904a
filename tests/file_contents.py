"""What two results files have in common: all of it, to the last bit."""

import h5py


def contents(path):
    """Every dataset of a results file."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, item: (
                found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None
            )
        )
    return found


def assert_equal_bits(one, other):
    """Refuse tables of datasets that differ anywhere."""
    assert one.keys() == other.keys()
    for name, values in one.items():
        if values.dtype == object:
            assert values.tolist() == other[name].tolist()
        else:
            assert values.tobytes() == other[name].tobytes(), name
