// The order of a source's columns for its target: the farthest side first. To an eye on the right near things move to the left, so among the
// samples that land on one column the rightmost is the nearest; to an eye on the left all is mirrored.

fn is_mirrored() -> bool { return frame.parallax_px < 0.0; }

// The column that comes so late in a sweep, and how late a column comes.
fn in_sweep(place: u32) -> u32 { return select(place, frame.image_size.x - 1u - place, is_mirrored()); }

// Of a sample: larger the later its column comes; never EMPTY.
fn key_of(column: u32) -> u32 { return in_sweep(column) + 1u; }
fn column_of(key: u32) -> u32 { return in_sweep(key - 1u); }
