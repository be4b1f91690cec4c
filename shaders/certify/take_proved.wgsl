// A pixel takes a proved answer; the host decides the other pixels.
fn taken(answer: Answer, k: NearestTwo) -> bool {
    return certain(answer, k);
}
