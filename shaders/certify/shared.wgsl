// A front sphere that came from another lane; past the end it is none.
fn shared_front(s: Slopes, k: Kept, f: Front, slot: u32) -> Kept {
    if (slot < lens.fronts) {
        return keep(k, front_low(s, f), slot);
    }
    return k;
}
