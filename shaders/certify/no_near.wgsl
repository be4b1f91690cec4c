// Every sphere is wholly in front. Software adapters run what is written, entered or not, so the rest is not written.
fn keep_nears(s: Slopes, k: Kept) -> Kept {
    return k;
}

fn judge_near(s: Slopes, k: Kept, other: Answer) -> Answer {
    return other;
}
