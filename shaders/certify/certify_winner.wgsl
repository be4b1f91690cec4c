// Only the winner is certified: by its own error bounds, and by comparison with the second smallest lower bound.

fn certify_winner(s: Slopes, k: NearestTwo) -> Answer {
    var answer = Answer(true, true, NONE, MISS, 0.0, 0.0, 0.0, vec3<f32>(0.0, 0.0, 0.0), 0.0);
    if ((k.slot & GENERAL) == 0u) {
        answer = projected_answer(s, winner_record(k.slot), projected_detail(k.slot));
    }
    return certify_general(s, k, answer);
}

// Whether hit, root and normal are certain, no other sphere can be as near, and the depth is within the tolerance. A
// depth that may have been flushed as a subnormal is never certain, nor is one that is not in front of all that the
// search may skip: so the result does not depend on what is skipped.
fn certain(answer: Answer, k: NearestTwo) -> bool {
    let depth = projection.depth + answer.low;
    let sharp = answer.depth_interval < projection.tolerance * depth && depth > VANISH;
    let in_front = answer.high - k.low < projection.cull_margin * (projection.depth + k.low);
    return answer.sure && answer.high < k.second && sharp && in_front;
}
