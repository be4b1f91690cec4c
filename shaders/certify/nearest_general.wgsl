// The general spheres of a ray, from general_few.wgsl or general_lists.wgsl, which have general_at.

// The winner's answer if it is a general sphere, otherwise `other`.
fn certify_general(s: Slopes, k: NearestTwo, other: Answer) -> Answer {
    if ((k.slot & GENERAL) != 0u && k.slot != NONE) {
        return general_answer(s, general_at(k.slot & ~GENERAL));
    }
    return other;
}
