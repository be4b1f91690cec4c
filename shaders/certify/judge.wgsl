// The winner alone is judged: by its own bounds, and against the second smallest lower bound.

fn judge(s: Slopes, k: Kept) -> Answer {
    if ((k.slot & NEAR) != 0u) {
        return near_answer(s, nears[k.slot & ~NEAR]);
    }
    return front_answer(s, fronts[k.slot], front_mores[k.slot]);
}

// Hit, root and normal are certain, nobody else can be as near, and the depth is as sharp as promised. A depth that may
// have lost bits below the normal numbers never is.
fn certain(answer: Answer, k: Kept) -> bool {
    let depth = lens.depth + answer.low;
    let sharp = answer.high - answer.low < lens.tolerance * depth && depth > VANISH;
    return answer.sure && answer.high < k.second && sharp;
}
