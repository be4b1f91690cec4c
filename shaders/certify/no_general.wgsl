// Every sphere is wholly in front. Software adapters run what is written, entered or not, so the rest is not written.
fn nearest_two_generals(s: Slopes, k: NearestTwo) -> NearestTwo {
    return k;
}

fn certify_general(s: Slopes, k: NearestTwo, other: Answer) -> Answer {
    return other;
}
