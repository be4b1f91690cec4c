// A pixel takes what is proved; the host decides the others.
fn taken(answer: Answer, k: NearestTwo) -> bool {
    return certain(answer, k);
}
