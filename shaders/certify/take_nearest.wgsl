// A pixel takes its nearest candidate, proved or not. The host decides the rare one whose root f32 does not put in front of the eye.
fn taken(answer: Answer, k: NearestTwo) -> bool {
    return (k.slot & GENERAL) == 0u || answer.offset > 0.0;
}
